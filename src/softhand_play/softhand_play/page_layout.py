"""Layout of the page: the status over the view, and on a phone the panel below the view.

viser lays its panel over the lower right of a narrow window. The style makes the view and the panel
two rows, so that the hand stays visible; the panel is folded by its title. viser hides all that is
in a folded panel, so the script copies the status to an element of its own.
"""

from __future__ import annotations

import json

PHONE_WIDTH = "36em"  # below which viser shows its panel for phones
PANEL = '[style*="position: fixed"][style*="max-height: 60%"]'  # viser's panel for phones
STYLE = f"""
.softhand-status {{ display: none }}
#softhand-status {{
  position: fixed; left: 5em; bottom: 0.8em; max-width: calc(100vw - 28em); z-index: 300;
  padding: 0.3em 0.7em; border-radius: 0.4em; background: rgba(255, 255, 255, 0.88);
  color: black; line-height: 1.3; pointer-events: none; overflow-wrap: anywhere;
}}
.softhand-plain, .softhand-success, .softhand-error {{ font-weight: bold }}
.softhand-success {{ color: #0b6b1f }}
.softhand-error {{ color: #b3120b }}
#softhand-status:has(.softhand-success:not(:empty)) {{ border-left: 0.3em solid #0b6b1f }}
#softhand-status:has(.softhand-error:not(:empty)) {{ border-left: 0.3em solid #b3120b }}
@media (max-width: {PHONE_WIDTH}) {{
  #softhand-status {{ left: 0; right: 0; top: 0; bottom: auto; max-width: none; border-radius: 0 }}
  .mantine-Notifications-root {{ top: 5em !important }}
  :has(> {PANEL}) {{ flex-direction: column }}
  :has(+ {PANEL}) {{ height: auto !important; min-height: 0; width: 100% }}
  {PANEL} {{ position: relative !important; width: 100% !important; max-height: 50% !important;
    flex: none }}
  {PANEL} [style*="width: 20em"] {{ width: 100% !important }}
}}
"""
SCRIPT = """
document.title = {title};
if (!document.getElementById("softhand-status")) {{
  document.head.appendChild(document.createElement("style")).textContent = {style};
  const shown = document.body.appendChild(document.createElement("div"));
  shown.id = "softhand-status";
  new MutationObserver(() => {{
    const status = document.querySelector(".softhand-status");
    if (status && shown.innerHTML != status.innerHTML) shown.innerHTML = status.innerHTML;
  }}).observe(document.body, {{childList: true, subtree: true, characterData: true}});
}}
"""


def layout_script(title: str) -> str:
    """The script that lays out the page and sets the title of its tab in the browser."""
    return SCRIPT.format(title=json.dumps(title), style=json.dumps(STYLE))
