"""YAML that is no valid file of a wall, areas or a path, though some of it looks like one."""
TAG = '{id: 1, x: 0, y: 0, side: 1}'
TAGS = 'tags:\n' + ''.join('- {id: %d, x: 0, y: 0, side: 1}\n' % number for number in range(1, 5))
AREA = 'ids: [1, 2, 3, 4]'
START = 'start: {x: 0, y: 0, heading: 0}\n'


def _billion_laughs(names, form):
    """Each name stands for nine copies of the name before."""
    return ''.join('%s: &%s %s\n' % (after, after, form % ','.join(['*' + before] * 9))
                   for before, after in zip(names, names[1:]))


# Short texts that expand enormously, or refer to themselves, and long or deep ones.
ENDLESS = {
    'laughs': 'a: &a [x,x,x,x,x,x,x,x,x]\n' + _billion_laughs('abcdefghijklmnopq', '[%s]') + 'tags: [{id: *q}]',
    'merged laughs': 'a: &a {x: 1}\n' + _billion_laughs('abcdefghijklmn', '{<<: [%s]}'),
    'circle': 'areas: &a [*a]\ntags: [*a]\nlegs: [*a]\n',
    'deep': 'areas: ' + '[' * 9000,
    'deep maps': 'tags: ' + '{a: ' * 9000,
    'deep lines': ''.join('%s- \n' % (' ' * depth) for depth in range(600)),
    'keys in keys': '? ' * 9000,
    'quotes': '"' * 9999,
    'many areas': 'areas:\n' + 100 * ('- {%s}\n' % AREA),
    'many tags': 'tags:\n' + 600 * '- {id: 1, x: 0, y: 0, side: 1, turn: 0.0, name: some}\n',
    'long name': 'areas: [{%s, %s: 1}]' % (AREA, 'n' * 90000),
    'long value': 'areas: [{%s, fit: %s}]' % (AREA, 'n' * 90000),
}

NUMBERS = {
    'long number': 'tags: [{id: %s, x: 0, y: 0, side: 1}]' % ('9' * 5000),
    'long hex': 'tags: [{id: 0x%s, x: 0, y: 0, side: 1}]' % ('f' * 5000),
    'large': 'tags: [{id: 1, x: 1%s, y: 0, side: 1}]\n' % ('0' * 400),
    'long leg': START + 'legs: [{seconds: 1%s}]\n' % ('0' * 400),
    'yes': 'tags: [{id: 1, x: yes, y: no, side: on}]\n' + START + 'legs: [{seconds: yes}]\n'
           'areas: [{ids: [yes, no, on, 4]}]',
    'nan': 'tags: [{id: .nan, x: .nan, y: .inf, side: .nan}]\n' + START + 'legs: [{seconds: .nan}]\n'
           'areas: [{%s, opacity: .nan}]' % AREA,
    'infinite': 'tags: [{id: 1, x: -.inf, y: 0, side: .inf}]\n' + START + 'legs: [{seconds: .inf}]\n'
                'areas: [{%s, hold: .inf}]' % AREA,
    'slow': START + 'legs: [{seconds: 1.0e-300}]',
    'no number': 'tags: !!int ""',
    'no float': 'tags: !!float fast',
    'ids': 'tags: [{id: 250, x: 0, y: 0, side: 1}]\n',
    'below': 'tags: [{id: -1, x: 0, y: 0, side: 1}]\n',
}

KINDS = {
    'dates': 'tags: [{id: 1, x: 2001-01-01, y: 0, side: 1}]\nareas: [{ids: 2001-12-14t21:59:43.10-05:00}]',
    'no date': 'tags: 2001-99-99\nareas: 2001-99-99',
    'no time': 'legs: !!timestamp soon',
    'no truth': 'areas: !!bool maybe',
    'binary': 'tags: !!binary aGVsbG8=\nareas: !!binary "a"',
    'set': 'areas: !!set {a, b}\ntags: !!set {a}\nlegs: !!set {a}',
    'object': 'areas: !!python/object/apply:os.system ["exit 1"]',
    'unknown kind': 'areas: !area [1]',
    'pairs': 'areas: !!pairs [a: 1]\ntags: !!omap [a: 1]',
    'list as key': '[a, b]: 1',
    'map as key': '{a: b}: 1',
    'numbers as names': '1: 2\n3.0: 4\nnull: 5\n',
    'no map': 'areas',
    'number': '5',
    'null': 'null',
    'list': '[]',
    'nulls': 'tags: [null]\nareas: [null]\nstart: null\nlegs: [null]\nwall: null\n',
    'texts': 'tags: text\nareas: text\nstart: text\nlegs: text\n',
    'one as all': 'tags: %s\nareas: {%s}\n%slegs: {seconds: 1}\n' % (TAG, AREA, START),
    'no dictionary': 'dictionary: [a, b]\n' + TAGS,
    'colors': 'wall: {color: white}\n' + TAGS,
    'area of texts': 'area: [a, b, c, d]\n' + TAGS,
    'area of lists': 'area: [[1], [2], [3], [4]]\n' + TAGS,
    'picture': 'areas: [{%s, picture: [a]}]' % AREA,
    'picture of lines': 'areas: [{%s, picture: "a\\nb", fit: "\\ud800"}]' % AREA,
    'percents': 'areas: [{%s, fit: "%%s%%d%%"}]\ntags: "%%s"' % AREA,
}

FORMS = {
    'double': 'areas: []\nareas: [{%s}]\ntags: []\n%slegs: []\nlegs: []\n' % (AREA, TAGS),
    'double id': 'tags: [{id: 1, id: 2, x: 0, y: 0, side: 1}]\nareas: [{%s, %s}]\n' % (AREA, AREA),
    'zero': 'areas: [\0]',
    'tabs': 'tags:\n\t- {id: 1}',
    'two': 'areas: []\n---\nareas: []\n',
    'three dots': '...',
    'comment': '# nothing',
}

TEXTS = {**{name: text.encode() for part in (ENDLESS, NUMBERS, KINDS, FORMS) for name, text in part.items()},
         'latin': ('areas: [{%s, picture: Erd\xe4pfel}]' % AREA).encode('latin1'),
         'half a mark': b'\xff\xfeareas: []',
         'huge': b'areas: []\n' + b'# more\n' * 10**7}
