"""What Sphinx is told: script/docs calls it."""
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(os.path.dirname(HERE), 'src'), HERE]
sys.path.append(os.path.join(os.path.dirname(HERE), 'test'))  # for its corpus of mistakes

import generated  # noqa: E402  found there

generated.write_all(os.path.join(HERE, 'generated'))

project = 'unit5'
html_title = 'unit5: augmented reality with ArUco tags'
extensions = ['myst_parser', 'sphinx.ext.autodoc']
exclude_patterns = ['generated']

myst_heading_anchors = 3  # so that [text](page.md#a-heading) works

autodoc_member_order = 'bysource'
autodoc_typehints = 'none'  # the docstrings say the shapes of arrays, which types do not

toc_object_entries = False  # functions would make the menu long

html_theme = 'alabaster'
html_static_path = ['_static']
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_theme_options = {
    'description': 'Augmented reality with ArUco tags',
    'fixed_sidebar': True,
    'page_width': '1240px',
    'sidebar_width': '260px',
}
html_sidebars = {'**': ['about.html', 'searchbox.html', 'navigation.html']}
