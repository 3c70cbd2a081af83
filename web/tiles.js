// The tiles: each shows a topic. A click enlarges one. Only frames of visible tiles are requested.
import { decoder, decodes } from './video.js';

const WIDTH_STEP = 160;

export function tiles(send) {
  const all = new Map();

  for (const element of document.querySelectorAll('.tile')) {
    const tile = { element, topic: element.dataset.topic, inView: false,
                   canvas: element.querySelector('canvas'), button: element.querySelector('.view'),
                   why: element.querySelector('.why'), advice: element.querySelector('.advice'),
                   problem: '', advised: '', failed: false, video: decoder() };
    all.set(tile.topic, tile);
    tile.button.addEventListener('click', () => enlarge(tile.element.classList.contains('large') ? null : tile));
  }
  const observer = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) all.get(target.dataset.topic).inView = isIntersecting;
    requestFrames();
  }, { rootMargin: '100px' });
  for (const { element } of all.values()) observer.observe(element);
  document.addEventListener('visibilitychange', requestFrames);
  addEventListener('resize', requestFrames);
  document.addEventListener('keydown', ({ key }) => { if (key === 'Escape') enlarge(null); });

  function enlarge(large) {
    for (const tile of all.values()) {
      const name = tile.button.getAttribute('aria-label').split(': ')[0];
      tile.element.classList.toggle('large', tile === large);
      tile.element.classList.toggle('aside', large !== null && tile !== large);
      tile.element.style.order = tile === large ? -1 : 0;
      if (large && tile !== large) clear(tile);
      tile.button.setAttribute('aria-expanded', tile === large);
      tile.button.setAttribute('aria-label', `${name}: ${tile === large ? 'make small' : 'enlarge'}`);
    }
    if (large) large.element.scrollIntoView({ block: 'nearest' });
    requestFrames();
  }

  // Tell the server which topics are visible. While one tile is large, this is the only one.
  function requestFrames() {
    const large = [...all.values()].find(({ element }) => element.classList.contains('large'));
    const seen = document.hidden ? [] : large ? [large] : [...all.values()].filter((tile) => tile.inView);
    // Larger frames than a tile shows would only take time. In steps, so that browsers share what is encoded.
    const widest = Math.max(1, ...seen.map(({ canvas }) => canvas.parentElement.clientWidth));
    const width = Math.ceil(widest * devicePixelRatio / WIDTH_STEP) * WIDTH_STEP;
    send({ look: seen.map(({ topic }) => topic), width, h264: decodes() });
  }

  async function frame(head, data) {
    const tile = all.get(head.topic);
    if (!tile) return;
    try {
      const picture = 'key' in head ? await tile.video(data, head.key) : await createImageBitmap(new Blob([data], { type: 'image/jpeg' }));
      const [width, height] = [picture.displayWidth ?? picture.width, picture.displayHeight ?? picture.height];
      if (tile.canvas.width !== width || tile.canvas.height !== height) [tile.canvas.width, tile.canvas.height] = [width, height];
      tile.canvas.getContext('2d').drawImage(picture, 0, 0);
      picture.close();
    } catch (error) {
      if (!('key' in head)) throw error;
      send({ lost: head.topic });
    } finally {
      send({ shown: head.topic });
    }
    tile.problem = '';
    explain(tile);
    const write = (name, text) => { tile.element.querySelector(name).textContent = text; };
    write('.rate', `${Math.round(head.rate)} fps`);
    write('.latency', head.latency === null ? '– ms' : `${head.latency} ms`);
    write('.tags', head.tags === null ? '' : head.tags.length ? `tags ${head.tags.join(' ')}` : 'no tags');
  }

  function showProblem(topic, why) {
    const tile = all.get(topic);
    if (!tile) return;
    tile.problem = why;
    explain(tile);
    clear(tile);
  }

  // What the nodes say of themselves: {topic: [sentence, whether it says why there are no frames]}.
  function advise(sentences) {
    for (const tile of all.values()) {
      [tile.advised, tile.failed] = sentences[tile.topic] ?? ['', false];
      explain(tile);
    }
  }

  // Without frames, the reason is where the picture should be; the node may know it better than the server.
  function explain({ why, advice, problem, advised, failed }) {
    why.hidden = !problem;
    why.textContent = problem && (failed ? advised : problem);
    advice.hidden = Boolean(problem) || !advised;
    advice.textContent = advised;
  }

  function clear(tile) {
    for (const figure of tile.element.querySelectorAll('.figures span')) figure.textContent = '–';
  }

  return { frame, showProblem, advise, requestFrames, lost() { advise({}); for (const topic of all.keys()) showProblem(topic, 'No connection to the server.'); } };
}
