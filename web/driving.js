// Driving: while a key or button is held, commands are repeated. The server stops the robot when they end.
const REPEAT_MS = 100;
const KEYS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, 1], ArrowRight: [0, -1] };
const OWN_KEYS = 'input, select, textarea, [contenteditable]';  // elements that use the arrow keys themselves

export function driving(send) {
  const section = document.getElementById('drive');
  const held = new Map();  // key or button -> [forward, left]
  let timer = null;

  function hold(what, direction) {
    if (section.hidden || held.has(what)) return;
    held.set(what, direction);
    timer ??= setInterval(command, REPEAT_MS);
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
    if (event.metaKey) stop();  // while Command is held, macOS reports no released keys
    if (section.hidden || !KEYS[event.key] || event.target.closest(OWN_KEYS)
        || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();  // the page must not scroll
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
    button.addEventListener('contextmenu', (event) => event.preventDefault());  // a long touch opens no menu
  }

  return { allow(drive) { section.hidden = !drive; if (!drive) stop(); } };
}
