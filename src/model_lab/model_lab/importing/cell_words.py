"""Words in cells and names: the direction of a valve pulse, and the mode of a test of rubber."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

from model_lab.measurements.measurement_set import DEFLATE, INFLATE, MODES

TENSION_MODE, SHEAR_MODE, BIAXIAL_MODE = MODES
MODE_WORDS = {
    BIAXIAL_MODE: ("biaxi", "biax", "bulge", "zweiachsig"),
    SHEAR_MODE: ("pureshear", "planar", "reinerschub", "cisaillementpur", "cizallapura"),
    TENSION_MODE: ("uniax", "einachsig", "tensile", "zugversuch", "traction", "traccion"),
}  # parts of names; of two modes the first one counts: planar tension, biaxial traction
MODE_SIGNS = {
    **dict.fromkeys(("ut", "zug", "tension"), TENSION_MODE),
    "eb": BIAXIAL_MODE,
    "ps": SHEAR_MODE,
}  # whole words of names
BIAXIAL_CAPITALS = re.compile(r"(?<![A-Za-z])ET(?![A-Za-z])")  # in small letters "and" in French
DIRECTION_WORDS = {
    INFLATE: "inflate inflation inflating in fill filling einlass einstromen beluften fullen "
    "befullen gonfler gonflage remplir admission inflar inflado llenar",
    DEFLATE: "deflate deflation deflating out vent venting exhaust empty auslass ausstromen "
    "entluften leeren entleeren degonfler degonflage vider echappement desinflar desinflado vaciar",
}
_DIRECTIONS = {word: value for value, words in DIRECTION_WORDS.items() for word in words.split()}


def words(name: str) -> list[str]:
    """The words and numbers in a name, in lower case and without accents; capitals begin a word
    too.

    >>> words("IndexTip_x [mm]"), words("p1"), words("Prüfkörper")
    (['index', 'tip', 'x', 'mm'], ['p', '1'], ['prufkorper'])
    """
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    plain = unicodedata.normalize("NFKD", parted.casefold())
    letters = "".join(letter for letter in plain if not unicodedata.combining(letter))
    return re.findall(r"[a-z]+|\d+", letters)


def mode_in(name: str) -> str:
    """The mode of deformation (one of MODES) that a name contains; "" if it contains none.

    ET in capitals stands for equibiaxial tension; in small letters it is the French for "and".

    >>> mode_in("pure_shear_2"), mode_in("Planar tension"), mode_in("run 1"), mode_in("äquibiaxial")
    ('pure_shear', 'pure_shear', '', 'equibiaxial')
    >>> mode_in("Treloar_ET"), mode_in("contrainte_et_deformation")
    ('equibiaxial', '')
    """
    parts = words(name)
    joined = "".join(parts)
    for mode, known in MODE_WORDS.items():
        if any(word in joined for word in known):
            return mode
    if BIAXIAL_CAPITALS.search(name):
        return BIAXIAL_MODE
    return next((MODE_SIGNS[word] for word in parts if word in MODE_SIGNS), "")


def directions(cells: Iterable[str]) -> list[float] | None:
    """INFLATE or DEFLATE for each cell; None unless all are words for a direction of pulses.

    >>> directions(["Belüften", "Entlüften"]), directions(["up", "down"])
    ([1.0, -1.0], None)
    """
    found = [_DIRECTIONS.get("".join(words(cell))) for cell in cells]
    known = [one for one in found if one is not None]
    return known if known and len(known) == len(found) else None
