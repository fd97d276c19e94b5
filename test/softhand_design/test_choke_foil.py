"""The choke foil: holes where and as large as asked for, and what flows through them."""

from xml.etree import ElementTree

import numpy as np
import pytest

from softhand_design.choke_foil import LITRE_MASS, FoilParameters, foil_drawing, nominal_flow
from softhand_design.commands.choke_foil import main
from softhand_model.pneumatics.parameters import load_pneumatics

NAMES = {"s": "http://www.w3.org/2000/svg"}


def circles(text, layer, kind):
    """Centres (k, 2) and diameters (k,) [mm] of the circles of a kind in a layer."""
    found = ElementTree.fromstring(text).iterfind(
        f"s:g[@id='{layer}']/s:circle[@class='{kind}']", NAMES
    )
    rows = np.array([[float(c.get(key)) for key in ("cx", "cy", "r")] for c in found])
    rows = rows.reshape(-1, 3)
    return rows[:, :2], 2.0 * rows[:, 2]


def test_the_usual_foil_has_the_holes_of_the_thesis_in_the_middle_of_every_port():
    """Section 4.3: 0.2 mm to inflate, 0.6 mm to deflate."""
    text = foil_drawing(FoilParameters())
    for kind, size in (("inlet", 0.2), ("outlet", 0.6)):
        places, sizes = circles(text, "pierce", kind)
        ports, _ = circles(text, "marks", f"{kind}-port")
        assert sizes == pytest.approx([size] * 8)
        assert places == pytest.approx(ports)


def test_a_hole_that_a_plotter_can_cut_is_cut_and_not_pierced():
    """Fig. 4.5c: outlet holes of 4 mm, various numbers of inlet holes of 0.2 mm."""
    text = foil_drawing(FoilParameters(outlet_diameter=4.0, inlet_holes=5, channels=3))
    assert len(circles(text, "cut", "outlet")[1]) == 3
    assert len(circles(text, "pierce", "outlet")[1]) == 0
    assert len(circles(text, "pierce", "inlet")[1]) == 15


@pytest.mark.parametrize("count", [1, 2, 7, 12])
def test_holes_lie_within_their_ports_apart_from_each_other_and_within_the_foil(count):
    text = foil_drawing(FoilParameters(inlet_holes=count))
    places, sizes = circles(text, "pierce", "inlet")
    ports, widths = circles(text, "marks", "inlet-port")
    away = np.linalg.norm(places[:, None] - ports, axis=2).min(axis=1)
    assert (away + sizes / 2 < widths[0] / 2).all()
    between = np.linalg.norm(places[:, None] - places, axis=2) + 9.0 * np.eye(len(places))
    assert between.min() > 2.9 * sizes[0]
    size = [float(n) for n in ElementTree.fromstring(text).get("viewBox").split()]
    assert (ports - widths[0] / 2 > 5.9).all() and (ports + widths[0] / 2 < size[2:]).all()


def test_flow_is_that_of_sonic_holes():
    """Saint-Venant: m = C A p sqrt(g/(R T)) (2/(g+1))^((g+1)/(2(g-1))), and as many times more."""
    box, g = load_pneumatics(), 1.4
    supply = box.supply.pressure + box.ambient_pressure
    sonic = np.sqrt(g / (287.05 * box.temperature)) * (2 / (g + 1)) ** ((g + 1) / (2 * (g - 1)))
    area = np.mean(box.choke.discharge_coefficient) * np.pi / 4 * 0.2e-3**2
    expected = 60.0 * area * supply * sonic / LITRE_MASS
    assert nominal_flow(1, 0.2, box) == pytest.approx(expected, rel=1e-3)
    assert nominal_flow(7, 0.2, box) == pytest.approx(7.0 * expected, rel=1e-3)


def test_the_flow_can_be_chosen_over_two_orders_of_magnitude():
    """Section 4.3: without a choke 50 to 200 slpm."""
    box = load_pneumatics()
    flows = nominal_flow(1, 0.2, box), nominal_flow(1, 4.0, box)
    assert flows[1] / flows[0] == pytest.approx(400.0) and flows[1] > 200.0


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--inlet-holes", "90"], "inlet_holes: expected at most 12 holes of 0.2 mm in a port"),
        (["--outlet-diameter", "6"], "outlet_diameter: expected less than the port's diameter"),
        (["--pitch", "4"], "pitch: expected more than the port's diameter, 5 mm, got 4"),
        (["--channels", "0"], "channels: expected a number above 0, got 0"),
        (["--margin", "nan"], "margin: expected a number above 0, got nan"),
    ],
)
def test_what_cannot_be_made_is_refused_in_a_line(options, message, tmp_path, capsys):
    out = tmp_path / "foil.svg"
    assert main([*options, "-o", str(out)]) == 2
    assert message in capsys.readouterr().err and not out.exists()


def test_the_command_writes_once_and_prints_the_flows(tmp_path, capsys):
    out = tmp_path / "foil.svg"
    assert main(["-o", str(out)]) == 0
    told = capsys.readouterr().out
    assert "inlet: 1 x 0.2 mm, 1.1 slpm from 300 kPa to ambient" in told and str(out) in told
    assert main(["-o", str(out)]) == 2
    assert main(["-o", str(out), "--force"]) == 0
    assert main(["-o", str(tmp_path / "foil.txt")]) == 2
