// The websocket to the server. It carries JSON objects in both directions, and frames from the server.
const RECONNECT_MS = 1000;

// Calls opened(), closed(), received(object) and frame(object, bytes). Reconnects when the connection breaks.
export function connect({ opened, closed, received, frame }) {
  const address = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/live`;
  let socket = null;

  function open() {
    socket = new WebSocket(address);
    socket.binaryType = 'arraybuffer';
    socket.onopen = opened;
    socket.onclose = () => { closed(); setTimeout(open, RECONNECT_MS); };
    socket.onmessage = ({ data }) => {
      if (typeof data === 'string') { received(JSON.parse(data)); return; }
      const length = new DataView(data).getUint32(0);
      const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
      frame(head, new Uint8Array(data, 4 + length));
    };
  }
  setTimeout(open);  // later, so that the caller has set up its callbacks

  return { send(object) { if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(object)); } };
}
