// Filming with this device: its camera's frames are sent to the server, each when the one before has arrived.
const WISH = { audio: false, video: { facingMode: { ideal: 'environment' }, width: { ideal: 1280 }, height: { ideal: 720 } } };
const QUALITY = 0.8;

export function filming(say) {
  const section = document.getElementById('film');
  if (!section) return;
  const button = section.querySelector('button');
  const video = section.querySelector('video');
  const canvas = document.createElement('canvas');
  let socket = null;
  let stream = null;

  button.addEventListener('click', () => (stream ? stop() : start()));

  async function start() {
    if (!navigator.mediaDevices) { say('The browser gives no camera to this page. Open it by https://.', true); return; }
    try {
      stream = await navigator.mediaDevices.getUserMedia(WISH);
    } catch (error) {
      say(`This device's camera cannot be used (${error.message}). Allow it in the browser's settings of this page.`, true);
      return;
    }
    video.srcObject = stream;
    video.hidden = false;
    await video.play();
    button.textContent = 'Stop filming';
    navigator.wakeLock?.request('screen').catch(() => {});  // otherwise the phone sleeps after a minute
    socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/film`);
    socket.onopen = send;
    socket.onmessage = send;  // the last frame has arrived
    socket.onclose = ({ reason }) => { if (stream) { stop(); say(reason || 'The server no longer takes frames.', true); } };
  }

  function stop() {
    for (const track of stream.getTracks()) track.stop();
    stream = video.srcObject = null;
    video.hidden = true;
    socket?.close();
    button.textContent = 'Film with this device';
  }

  function send() {
    const next = video.requestVideoFrameCallback ? (then) => video.requestVideoFrameCallback(then) : requestAnimationFrame;
    next(() => {
      if (!stream || socket.readyState !== WebSocket.OPEN) return;
      [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
      canvas.getContext('2d').drawImage(video, 0, 0);
      canvas.toBlob((jpeg) => { if (jpeg && socket.readyState === WebSocket.OPEN) socket.send(jpeg); }, 'image/jpeg', QUALITY);
    });
  }
}
