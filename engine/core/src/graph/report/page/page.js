// The page: figures, lists, details and search around the diagram, all from the report's JSON.

const find = id => document.getElementById(id);

// A frame's segments between checkpoints, one of which the page draws: `#segment=INDEX` in the address says which.
const address = () => new URLSearchParams(location.hash.slice(1));
const whole = JSON.parse(find('report').textContent);
const segments = [whole, ...(whole.later ?? [])];
const asked = () => segments[address().get('segment')] ?? whole;
const report = asked();

/** An HTML element. Text is set as text, never as markup. */
function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === 'onclick') node.onclick = value;
    else node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
}

// Names to objects. A Map, since a resource may be called `constructor`.
const resources = new Map(report.resources.map((resource, order) => [resource.name, { ...resource, order, uses: [] }]));
const known = name => {
  if (!resources.has(name)) resources.set(name, { name, kind: '', shape: '', origin: '', order: resources.size, uses: [] });
  return resources.get(name);
};
report.steps.forEach((step, index) => {
  for (const used of step.reads) known(used.resource).uses.push({ index, used, what: 'read' });
  for (const used of step.writes) known(used.resource).uses.push({ index, used, what: 'written' });
});
for (const [number, heap] of report.memory.heaps.entries()) {
  for (const placed of heap.placements) known(placed.resource).placed = { ...placed, heap: number };
}

/** What is said in words. */
const words = {
  count: (count, what) => `${count} ${what}${count === 1 ? '' : 's'}`,
  time: ms => (ms >= 1 ? `${ms.toFixed(2)} ms` : `${(ms * 1000).toFixed(0)} µs`),
  bytes(bytes) {
    if (bytes < 1024) return `${bytes} B`;
    const power = Math.min(4, Math.floor(Math.log2(bytes) / 10));
    return `${(bytes / 1024 ** power).toFixed(bytes < 100 * 1024 ** power ? 1 : 0)} ${['', 'KiB', 'MiB', 'GiB', 'TiB'][power]}`;
  },
  order: name => known(name).order,
  part: part => (part ? ` (${part})` : ''),
  step(index) {
    const step = report.steps[index];
    const what = step.kind === 'pass' ? 'Pass' : 'Read-back';
    const time = step.milliseconds === null ? '' : `, ${words.time(step.milliseconds)}`;
    return `${what} ${index}, ${step.name}, ${step.queue} queue, ${words.count(step.reads.length, 'read')}, `
      + `${words.count(step.writes.length, 'write')}, ${words.count(step.barriers.length, 'barrier')}${time}`;
  },
  resource(name) {
    const { kind, shape, placed } = known(name);
    const where = placed ? `, ${words.bytes(placed.bytes)} at ${placed.offset}, steps ${placed.steps.join(' to ')}` : '';
    return `Resource ${name}, ${kind} ${shape}${where}`;
  },
};

const stepButton = index =>
  el('button', { type: 'button', class: 'name', onclick: () => choose('step', index, true) }, report.steps[index].name);
const resourceButton = name =>
  el('button', { type: 'button', class: 'name', onclick: () => choose('resource', name, true) }, name);
const flags = text => el('span', { class: 'flags' }, text);
const muted = text => el('span', { class: 'muted' }, text);

/** A titled list; nothing where it has no items. */
const list = (title, items) => (items.length ? [el('h4', {}, title), el('ul', { class: 'uses' }, ...items)] : []);

function useItem(used) {
  const layout = used.layout ? `, ${used.layout}` : '';
  return el('li', {}, resourceButton(used.resource), muted(`${words.part(used.part)} as ${used.slot}`),
    flags(`${used.stages}: ${used.access}${layout}`));
}

function barrierItem(barrier) {
  const what = barrier.resource === null ? 'all memory' : resourceButton(barrier.resource);
  const [from, to] = [barrier.from, barrier.to].map(([stages, access]) =>
    [stages || 'nothing', access].filter(Boolean).join(': '));
  const item = el('li', {}, what, words.part(barrier.part), `: ${barrier.reason}`, flags(`${from} → ${to}`));
  if (barrier.layouts && barrier.layouts[0] !== barrier.layouts[1]) item.append(flags(barrier.layouts.join(' → ')));
  if (barrier.families) item.append(flags(`queue family ${barrier.families.join(' → ')}`));
  return item;
}

/** All about a step. */
function aboutStep(index) {
  const step = report.steps[index];
  const facts = [`step ${index} of ${report.steps.length}`, `${step.queue} queue`];
  if (step.kind !== 'pass') facts.push(step.kind);
  if (step.milliseconds !== null) facts.push(words.time(step.milliseconds));
  if (report.critical_path?.includes(index)) facts.push('on the critical path');
  if (step.side_effect) facts.push(`runs for its side effect: ${step.side_effect}`);
  const batch = report.batches?.[step.batch];
  const isFirst = index === report.steps.findIndex(other => other.batch === step.batch);
  const isLast = index === report.steps.findLastIndex(other => other.batch === step.batch);
  const waits = isFirst && batch ? batch.waits : [], releases = isLast && batch ? batch.release : [];
  const depends = step.depends ?? [];
  return [
    el('div', { class: 'muted' }, facts.join(' · ')),
    ...list('Reads', step.reads.map(useItem)),
    ...list('Writes', step.writes.map(useItem)),
    ...list('Needs', depends.map(({ step: from, resource, part, overwrites }) => el('li', {}, stepButton(from),
      muted(` ${overwrites ? 'wrote before it' : 'made'} ${resource}${words.part(part)}`)))),
    ...list('Waits for', waits.map(wait => el('li', {}, `${wait.queue} queue, value ${wait.value}`, flags(wait.stages)))),
    ...list('Barriers before it', step.barriers.map(barrierItem)),
    ...list('Handed over after it', releases.map(barrierItem)),
  ];
}

/** All about a resource. */
function aboutResource(name) {
  const { kind, shape, origin, placed, uses } = known(name);
  const apart = (report.memory.apart ?? []).filter(pair => pair.resources.includes(name));
  const body = [el('div', { class: 'muted' }, [origin, kind, shape].filter(Boolean).join(' · '))];
  if (placed) {
    body.push(el('p', {}, `${words.bytes(placed.bytes)} at byte ${placed.offset} of heap ${placed.heap}, `
      + `from step ${placed.steps[0]} to ${placed.steps[1]}`));
  }
  body.push(
    ...list('Used by', uses.map(({ index, used, what }) =>
      el('li', {}, stepButton(index), muted(`: ${what}${words.part(used.part)} as ${used.slot}`)))),
    ...list('Shares no memory with', apart.map(({ resources: [a, b], reason }) =>
      el('li', {}, resourceButton(a === name ? b : a), `: ${reason}`))));
  return body;
}

const about = (kind, key) => (kind === 'step' ? aboutStep(key) : aboutResource(key));
const nameOf = (kind, key) => (kind === 'step' ? report.steps[key].name : key);

// 1. Which segment, and figures.
find('graph').textContent = whole.graph;
document.title = `Render graph ${whole.graph}`;
find('segments').hidden = segments.length === 1;
find('segment').append(...segments.map(({ after }, index) => el('option', { value: index },
  `${index + 1} of ${segments.length}, ${after === undefined ? 'from the start' : `after ${after}`}`)));
find('segment').value = segments.indexOf(report);
find('segment').addEventListener('change', event => { location.hash = `segment=${event.target.value}`; });
const measured = report.steps.filter(step => step.milliseconds !== null);
const percent = Math.round(100 * report.memory.saved_bytes / Math.max(1, report.memory.unaliased_bytes));
const figures = [
  ['Steps', report.steps.length],
  ['Do not run', report.culled.length],
  ['Barrier calls', report.statistics.barrier_calls],
  ['Memory', words.bytes(report.memory.bytes)],
  ['Saved by sharing', `${words.bytes(report.memory.saved_bytes)}, ${percent} %`],
  ['Over the lower bound', `× ${report.memory.over_lower_bound.toFixed(3)}`],
];
if (report.critical_path) figures.push(['Critical path', words.count(report.critical_path.length, 'step')]);
if (measured.length) figures.push(['On the device', words.time(measured.reduce((sum, step) => sum + step.milliseconds, 0))]);
find('figures').append(...figures.map(([name, value]) => el('div', {}, el('dt', {}, name), el('dd', {}, `${value}`))));

// 2. Diagram.
const drawn = diagram(report, words);
const queues = new Set(report.steps.map(step => step.queue));
find('legend').append(
  ...[...queues].map(queue => el('span', {}, el('i', { class: queue.toLowerCase() }), `${queue} queue`)),
  el('span', {}, el('i', { class: 'critical' }), 'critical path'));

// 3. Lists. What an item holds is made when it is opened.
function item(kind, key, note) {
  const body = el('div', {});
  const details = el('details', {}, el('summary', {}, nameOf(kind, key), ' ', muted(note)), body);
  details.addEventListener('toggle', () => body.childNodes.length || body.append(...about(kind, key)));
  return el('li', {}, details);
}
const items = { step: new Map(), resource: new Map() };
for (const [index, step] of report.steps.entries()) {
  const time = step.milliseconds === null ? '' : ` · ${words.time(step.milliseconds)}`;
  const note = `${index} · ${words.count(step.barriers.length, 'barrier')}${time}`;
  items.step.set(index, item('step', index, step.kind === 'pass' ? note : `${note} · ${step.kind}`));
}
find('passes').append(...items.step.values());
if (report.finally.length) {
  const all = el('details', {}, el('summary', {}, muted(`${words.count(report.finally.length, 'barrier')} at the end`)),
    el('div', {}, el('ul', { class: 'uses' }, ...report.finally.map(barrierItem))));
  find('passes').append(el('li', {}, all));
}
for (const [name, { kind, shape }] of resources) {
  items.resource.set(name, item('resource', name, [kind, shape].filter(Boolean).join(' · ')));
}
find('resources').append(...items.resource.values());
const culled = report.culled.map(({ name, reason }) => ({ name, node: el('li', {}, el('b', {}, name), `: ${reason}`) }));
find('culled').append(...culled.map(({ node }) => node));
find('culled-section').hidden = !culled.length;

// 4. Memory.
const most = Math.max(1, report.memory.unaliased_bytes);
const measures = [
  ['Without sharing', report.memory.unaliased_bytes, ''], ['Heaps', report.memory.bytes, 'now'],
  ['Most alive at once', report.memory.lower_bound_bytes, ''],
];
find('memory').append(...measures.map(([name, bytes, kind]) => el('div', { class: 'measure' }, el('span', {}, name),
  el('b', { class: kind, style: `width: ${100 * bytes / most}%` }), el('span', {}, words.bytes(bytes)))));
if (report.memory.apart?.length) {
  const pairs = report.memory.apart.map(({ resources: [a, b], reason }) =>
    el('li', {}, resourceButton(a), ' and ', resourceButton(b), `: ${reason}`));
  const title = `Why the largest resources do not share memory: ${words.count(pairs.length, 'pair')}`;
  find('memory').append(el('details', {}, el('summary', {}, title), el('div', {}, el('ul', { class: 'uses' }, ...pairs))));
}

// 5. Details: of what the pointer or the focus is on, else of what was chosen.
let chosen = null;

function show(what) {
  const hint = 'Point at a pass or at a resource; choose it to keep it here.';
  const body = what ? [el('h3', {}, nameOf(...what)), ...about(...what)] : [el('p', { class: 'muted' }, hint)];
  find('about').replaceChildren(...body);
  const [kind, key] = what ?? [];
  const users = new Set(kind === 'resource' ? known(key).uses.map(({ index }) => index) : []);
  const step = kind === 'step' ? report.steps[key] : null;
  const used = new Set(step ? [...step.reads, ...step.writes].map(({ resource }) => resource) : []);
  drawn.steps.forEach((node, index) => node.classList.toggle('related', users.has(index)));
  drawn.resources.forEach((node, name) => node.classList.toggle('related', used.has(name)));
  for (const { node, from, to, resources: carried } of drawn.edges) {
    node.classList.toggle('related', step ? from === key || to === key : carried.includes(key));
  }
}

const nodeOf = (kind, key) => (kind === 'step' ? drawn.steps[key] : drawn.resources.get(key));

function choose(kind, key, scroll) {
  if (chosen) nodeOf(...chosen)?.classList.remove('selected');
  chosen = kind ? [kind, key] : null;
  find('details').classList.toggle('open', chosen !== null);
  show(chosen);
  const node = chosen && nodeOf(kind, key);
  node?.classList.add('selected');
  if (scroll && node) reveal(node);
}

/** Scrolls the diagram, and nothing else, until a node is in its middle. */
function reveal(node) {
  const [box, frame] = [node.getBoundingClientRect(), view.getBoundingClientRect()];
  view.scrollLeft += box.left + Math.min(box.width, frame.width) / 2 - frame.left - frame.width / 2;
  view.scrollTop += box.top + box.height / 2 - frame.top - frame.height / 2;
}

/** One stop for Tab in each group of nodes; arrows go on from there. */
function connect(kind, entries) {
  entries[0]?.[1].setAttribute('tabindex', 0);
  entries.forEach(([key, node], place) => {
    node.addEventListener('pointerenter', event => event.pointerType === 'mouse' && show([kind, key]));
    node.addEventListener('pointerleave', event => event.pointerType === 'mouse' && show(chosen));
    node.addEventListener('focus', () => show([kind, key]));
    node.addEventListener('blur', () => show(chosen));
    node.addEventListener('click', () => choose(kind, key, false));
    node.addEventListener('keydown', event => {
      const to = { ArrowRight: place + 1, ArrowLeft: place - 1, Home: 0, End: entries.length - 1 }[event.key];
      if (event.key === 'Enter' || event.key === ' ') choose(kind, key, false);
      else if (to === undefined) return;
      event.preventDefault();
      const next = entries[to]?.[1];
      if (!next) return;
      node.setAttribute('tabindex', -1);
      next.setAttribute('tabindex', 0);
      next.focus({ preventScroll: true });
      reveal(next);
    });
  });
}
connect('step', [...drawn.steps.entries()]);
connect('resource', [...drawn.resources.entries()]);
find('close').onclick = () => choose(null);
show(null);

// 6. Search. `#search=TEXT` in the address searches as well.
function search(text) {
  const wanted = text.trim().toLowerCase();
  const matches = name => wanted !== '' && name.toLowerCase().includes(wanted);
  const found = [];
  const mark = (kind, key) => {
    const is = matches(nameOf(kind, key));
    const [inList, node] = [items[kind].get(key), nodeOf(kind, key)];
    inList.firstChild.classList.toggle('match', is);
    inList.hidden = wanted !== '' && !is;
    node?.classList.toggle('match', is);
    if (is) found.push([kind, key]);
  };
  report.steps.forEach((_, index) => mark('step', index));
  for (const name of resources.keys()) mark('resource', name);
  const left = culled.filter(({ name, node }) => {
    node.classList.toggle('match', matches(name));
    node.hidden = wanted !== '' && !matches(name);
    return matches(name);
  });
  svg.classList.toggle('searching', wanted !== '');
  const count = kind => found.filter(([of]) => of === kind).length;
  const parts = [words.count(count('step'), 'step'), words.count(count('resource'), 'resource')];
  if (left.length) parts.push(`${left.length} that ${left.length === 1 ? 'does' : 'do'} not run`);
  find('found').textContent = wanted === '' ? '' : parts.join(', ');
  const first = found.find(([kind, key]) => nodeOf(kind, key));
  if (first) reveal(nodeOf(...first));
  return found;
}
find('search').addEventListener('input', event => search(event.target.value));
find('finder').addEventListener('submit', event => {
  event.preventDefault();
  const [first] = search(find('search').value);
  if (first) choose(...first, true);
});
addEventListener('keydown', event => {
  if (event.key === '/' && !event.ctrlKey && !event.metaKey && document.activeElement !== find('search')) {
    event.preventDefault();
    find('search').focus();
  } else if (event.key === 'Escape') choose(null);
});
function searchAddress() {
  const text = address().get('search');
  if (text === null) return;
  find('search').value = text;
  search(text);
}
addEventListener('hashchange', () => (asked() === report ? searchAddress() : location.reload()));
searchAddress();
