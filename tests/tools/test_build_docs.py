import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "tools"))
from build_docs import directives_to_markdown

MATH = r"""Posterior mean.

.. math::

    f_* = k_*^\top \alpha,
    \quad x < y

More text.
"""

SYSTEM = """    .. pydrake_system::

        name: Camera
        input_ports:
        - cloud

    | port | type |
"""


def test_an_equation_becomes_one_block_that_markdown_leaves_alone():
    text = directives_to_markdown(MATH)
    assert r"<div>$$f_* = k_*^\top \alpha, \quad x &lt; y$$</div>" in text.splitlines()
    assert text.startswith("Posterior mean.")
    assert text.endswith("More text.\n")


def test_an_equation_on_the_line_of_its_directive_is_kept():
    assert "<div>$$a = b$$</div>" in directives_to_markdown("Sum.\n\n.. math:: a = b\n\nEnd.")
    assert "<div>$$a = b$$</div>" in directives_to_markdown("Sum.\n\n.. math:: a = b")


def test_a_block_of_ports_becomes_code_and_the_table_stays():
    lines = directives_to_markdown(SYSTEM).splitlines()
    assert lines.index("    ```yaml") < lines.index("    name: Camera") < lines.index("    ```")
    assert lines[-1] == "    | port | type |"
    assert "    - cloud" in lines


def test_text_without_directives_is_unchanged():
    text = "A summary.\n\nArgs:\n    x: a value.\n"
    assert directives_to_markdown(text) == text
