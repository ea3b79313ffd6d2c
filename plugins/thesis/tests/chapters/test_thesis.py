"""What the thesis saw: the heading, the tables of the inference, and the stiffness."""

import pytest

from quickreturn.plugins.thesis.experiment import below_aluminium
from quickreturn.plugins.thesis.inference import tables
from quickreturn.plugins.thesis.page_data import inference_of
from quickreturn.plugins.thesis.tests.made_up_inference import made_up_inference
from tests.reports.pages import finding_of, one_run, plain, text_of


def test_the_heading_is_the_inference_where_there_is_one() -> None:
    inference = made_up_inference()
    content = one_run(data={inference_of: inference})
    assert finding_of(content, "thesis") == plain(tables.headline(inference))
    told = text_of(content)
    assert all(each in told for each in ("at 83 to 94 Hz with such a roller", "102 to 140 Hz with clearance", "1800 of 2160 halves"))
    assert finding_of(one_run(), "thesis") == "Its model beside the converged one"


def test_the_printed_stiffness_is_that_of_no_wrought_aluminium() -> None:
    """60.1 GPa for the printed section, by hand, against 68.9 and 73.1 GPa."""
    modulus = 2128.22 * 0.45359237 * 9.80665 * 0.0254**2 / (0.0381 * 0.003175**3 / 12.0)
    assert below_aluminium() == pytest.approx((1.0 - modulus / 68.95e9, 1.0 - modulus / 73.08e9), abs=1e-3)
