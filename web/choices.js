// The choices: which picture is painted and how, which tags count, and how the simulation looks.
const SLIDE_MS = 150;
const ANSWER_MS = 5000;  // a node may take this long for a change

export function choices(send, say) {
  const section = document.getElementById('picture');
  const group = section.querySelector('.pictures');
  const file = document.getElementById('file');
  const sections = ['picture', 'tags', 'simulation'].map((id) => document.getElementById(id));
  let shownNames = '';

  function show({ pictures, picture, sliders, fields, switches }, failed = false) {
    if (failed) changes.clear();
    if (pictures.join('/') !== shownNames && !group.matches(':active')) {
      shownNames = pictures.join('/');
      group.replaceChildren(...pictures.map(choice));
    }
    if (!isUnanswered(group, group.querySelector('input:checked')?.value === picture)) {
      for (const input of group.querySelectorAll('input')) input.checked = input.value === picture;
    }
    for (const label of document.querySelectorAll('[data-switch]')) {
      label.hidden = !(label.dataset.switch in switches);
      const on = switches[label.dataset.switch];
      if (!isUnanswered(label, has(label, on))) label.querySelector('input').checked = on;
    }
    for (const label of document.querySelectorAll('[data-slider]')) {
      const value = sliders[label.dataset.slider];
      label.hidden = value === undefined;
      if (value !== undefined && !isUnanswered(label, has(label, value))) label.querySelector('input').value = value;
      writeValue(label);
    }
    for (const label of document.querySelectorAll('[data-field]')) {
      const value = fields[label.dataset.field];
      label.hidden = value === undefined;
      const input = label.querySelector('input, select');
      if (value !== undefined && document.activeElement !== input && !isUnanswered(label, has(label, value))) input.value = value;
    }
    for (const part of sections) {
      part.hidden = !part.querySelector('[data-slider]:not([hidden]), [data-field]:not([hidden]), [data-switch]:not([hidden])');
    }
  }

  function choice(name) {
    const label = document.createElement('label');
    const input = Object.assign(document.createElement('input'), { type: 'radio', name: 'picture', value: name });
    const image = Object.assign(document.createElement('img'), { src: `/picture?name=${encodeURIComponent(name)}`, alt: '' });
    label.append(input, image, name.replace(/\.[^.]*$/, '').replaceAll('_', ' '));
    input.addEventListener('change', () => {
      changes.set(group, performance.now());
      send({ picture: name });
    });
    return label;
  }

  async function upload(picture) {
    if (!picture) return;
    say(`Uploading ${picture.name} …`);
    try {
      const answer = await fetch('/picture', { method: 'POST', body: picture });
      if (answer.ok) say(`${picture.name} is painted now.`);
      else say((await answer.text()).trim(), true);
    } catch {
      say(`${picture.name} could not be uploaded. Is it too large?`, true);
    }
  }

  file.addEventListener('change', () => { upload(file.files[0]); file.value = ''; });
  const dragging = (on) => (event) => { event.preventDefault(); document.body.classList.toggle('dropping', on); };
  document.addEventListener('dragover', dragging(true));
  document.addEventListener('dragleave', dragging(false));
  document.addEventListener('drop', (event) => { dragging(false)(event); upload(event.dataTransfer.files[0]); });

  // After a choice by mouse or touch, give up the focus, so that the arrow keys drive again.
  for (const part of sections) {
    part.addEventListener('click', ({ pointerType, target }) => {
      if (pointerType && !target.closest('[data-field]')) setTimeout(() => document.activeElement.blur());
    });
  }

  function writeValue(label) {
    label.querySelector('.value').textContent = label.querySelector('input').value;
  }

  for (const label of document.querySelectorAll('[data-switch]')) {
    label.addEventListener('change', ({ target }) => {
      changes.set(label, performance.now());
      send({ switch: [label.dataset.switch, target.checked] });
    });
  }

  for (const label of document.querySelectorAll('[data-field]')) {
    let byPointer = false;
    label.addEventListener('pointerdown', () => { byPointer = true; });
    label.addEventListener('keydown', () => { byPointer = false; });
    label.addEventListener('change', ({ target }) => {
      target.value = target.value.replace(/\s/g, '');  // as the node writes it
      changes.set(label, performance.now());
      send({ write: [label.dataset.field, target.value] });
      if (byPointer || target.type === 'text') target.blur();  // the arrow keys drive again
    });
  }

  // Between a change of a control and the answer, older values arrive. They would change it back.
  const changes = new Map();  // control -> the time of its last change that is unanswered
  function isUnanswered(control, answered) {
    if (answered) changes.delete(control);
    return control.matches(':active') || performance.now() - changes.get(control) < ANSWER_MS;
  }
  function has(label, value) {
    const input = label.querySelector('input, select');
    return value === (input.type === 'checkbox' ? input.checked : typeof value === 'number' ? Number(input.value) : input.value);
  }

  for (const label of document.querySelectorAll('[data-slider]')) {
    const input = label.querySelector('input');
    let timer = null;
    input.addEventListener('input', () => {
      writeValue(label);
      changes.set(label, performance.now());
      timer ??= setTimeout(() => { timer = null; send({ slide: [label.dataset.slider, Number(input.value)] }); }, SLIDE_MS);
    });
  }

  return { show };
}
