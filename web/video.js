// Frames as H.264, decoded by the browser itself. JPEGs take ten times as many bytes, but less time of the server.
// So H.264 is for pages that are not on the server's own machine; or for all, at an address that ends with ?h264.
const CONFIG = { codec: 'avc1.42E028', optimizeForLatency: true };
const IS_NEAR = ['localhost', '127.0.0.1', '[::1]'].includes(location.hostname) && location.search !== '?h264';
let supported = false;

// Browsers offer the decoder only to pages by HTTPS, or of their own machine.
export async function prepare() {
  supported = !IS_NEAR && 'VideoDecoder' in window && (await VideoDecoder.isConfigSupported(CONFIG)).supported;
}

export function decodes() {
  return supported;
}

// A function of (bytes, whether a stream begins with them) that returns a promise of a VideoFrame.
export function decoder() {
  let own = null;
  let answer = null;
  let count = 0;

  function start() {
    if (own && own.state !== 'closed') own.close();
    own = new VideoDecoder({ output: (frame) => answer.resolve(frame), error: (error) => answer?.reject(error) });
    own.configure(CONFIG);
  }

  return (data, isFirst) => new Promise((resolve, reject) => {
    answer = { resolve, reject };
    if (isFirst) start();
    own.decode(new EncodedVideoChunk({ type: isFirst ? 'key' : 'delta', timestamp: count++, data }));
  });
}
