"""How Sphinx builds these pages: `sphinx-build -W --keep-going -n docs build/docs`, with the extra `docs`."""

import sys
from importlib.metadata import version as installed
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS / "_extensions"))

project = "fesloop"
author = "The fesloop developers"
project_copyright = "The fesloop developers, Apache-2.0"
version = release = installed("fesloop")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx_copybutton", "sphinx_design",
              "docstring_pages", "generated_pages", "mathml"]
exclude_patterns = ["_*", "**/__pycache__"]
nitpicky = True
# Python's own documentation is not asked for: the build needs no network.
nitpick_ignore = [("py:class", "collections.abc.Mapping")]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Notebooks are kept without outputs, and run here; a cell that fails is an error.
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_in_temp = True

autodoc_member_order = "bysource"
# Types stand beside each parameter (`docstring_pages`), where there is room for them.
autodoc_typehints = "none"
autodoc_class_signature = "mixed"
autodoc_preserve_defaults = True
maximum_signature_line_length = 90
add_module_names = False

# Equations are MathML, which browsers draw themselves: pages ask nothing of the network.
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"fesloop {release}"
html_static_path = ["_static"]
html_css_files = ["fesloop.css"]
html_copy_source = False
html_show_sphinx = False
pygments_style = "friendly"
pygments_dark_style = "github-dark"
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True
copybutton_line_continuation_character = "\\"
