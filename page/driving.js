// Driving: while a key or button is held, the server is told again and again; it stops the robot when that ends.
const AGAIN_MS = 100;
const KEYS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };
const OWN_KEYS = 'input, select, textarea, [contenteditable]';  // what uses arrow keys itself

export function driving(send) {
  const section = document.getElementById('drive');
  const held = new Map();  // what is held -> [forward, left]
  let timer = null;

  function hold(what, direction) {
    if (section.hidden || held.has(what)) return;
    held.set(what, direction);
    timer ??= setInterval(command, AGAIN_MS);
    command();
  }

  function release(what) {
    if (!held.delete(what)) return;
    command();
  }

  function stop() {
    if (!held.size) return;
    held.clear();
    command();
  }

  function command() {
    const sum = (place) => [...held.values()].reduce((total, direction) => total + direction[place], 0);
    send({ drive: [sum(0), sum(1)] });
    if (!held.size) { clearInterval(timer); timer = null; }
    for (const button of section.querySelectorAll('button')) {
      const { forward, left } = button.dataset;
      button.classList.toggle('on', [...held.values()].some(([f, l]) => f === Number(forward) && l === Number(left)));
    }
  }

  document.addEventListener('keydown', (event) => {
    if (event.metaKey) stop();  // while it is held, macOS tells of no key that is let go
    if (section.hidden || !KEYS[event.key] || event.target.closest(OWN_KEYS)
        || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();  // no scrolling
    hold(event.key, KEYS[event.key]);
  });
  document.addEventListener('keyup', ({ key }) => release(key));
  window.addEventListener('blur', stop);
  document.addEventListener('visibilitychange', () => { if (document.hidden) stop(); });

  for (const button of section.querySelectorAll('button')) {
    const direction = [Number(button.dataset.forward), Number(button.dataset.left)];
    button.addEventListener('pointerdown', (event) => {
      button.setPointerCapture(event.pointerId);
      hold(button, direction);
    });
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture', 'blur']) {
      button.addEventListener(end, () => release(button));
    }
    button.addEventListener('keydown', (event) => {
      if (event.key === ' ' || event.key === 'Enter') { event.preventDefault(); hold(button, direction); }
    });
    button.addEventListener('keyup', ({ key }) => { if (key === ' ' || key === 'Enter') release(button); });
    button.addEventListener('contextmenu', (event) => event.preventDefault());  // a long touch
  }

  return { allow(drive) { section.hidden = !drive; if (!drive) stop(); } };
}
