// The websocket to the server: JSON objects both ways, and frames from there.
const AGAIN_MS = 1000;

// Calls opened(), closed(), said(object) and frame(object, Blob); connects again when it breaks.
export function connect({ opened, closed, said, frame }) {
  const address = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/live`;
  let socket = null;

  function open() {
    socket = new WebSocket(address);
    socket.binaryType = 'arraybuffer';
    socket.onopen = opened;
    socket.onclose = () => { closed(); setTimeout(open, AGAIN_MS); };
    socket.onmessage = ({ data }) => {
      if (typeof data === 'string') { said(JSON.parse(data)); return; }
      const length = new DataView(data).getUint32(0);
      const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
      frame(head, new Blob([new Uint8Array(data, 4 + length)], { type: 'image/jpeg' }));
    };
  }
  setTimeout(open);  // when who called has what it needs to answer

  return { send(object) { if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(object)); } };
}
