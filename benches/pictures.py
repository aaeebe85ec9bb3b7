"""Pictures of the reports of real arms, for README.md and the documents.

    TORQUEWISE_SHARED=FOLDER python benches/pictures.py [NAME ...]

FOLDER/data holds the public logs that profiles/ names. The program is `torquewise` on the path or what
TORQUEWISE names, the browser `chromium` or what TORQUEWISE_CHROMIUM names. Writes docs/images/NAME.png.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOGS = {  # by the name of the profile: log, height of the picture
    "ur10": ("ur10_panda_unisa/ur10_exciting_trajectory.db3", 1540),
    "panda": ("ur10_panda_unisa/panda_exciting_trajectory.db3", 1870),
    "staubli_tx40": ("staubli_tx40_figaroh/pos_read_data.csv", 1540),
    "dfki_double_pendulum": (
        "dfki_double_pendulum/A0_20220812/20220812-061157-PM_measured.csv", 1070,
    ),
}  # fmt: skip
PARTS = ("Torque", "Geometry")  # sections that are shown, of the whole report
HIDDEN = "nav, header, details, .caption, section { display: none !important }"
SHOWN = "{ display: block !important }"
WIDTH = 1100


def main():
    program = os.environ.get("TORQUEWISE", "torquewise")
    browser = os.environ.get("TORQUEWISE_CHROMIUM", "chromium")
    data = Path(os.environ["TORQUEWISE_SHARED"]) / "data"
    for name in sys.argv[1:] or LOGS:
        log, height = LOGS[name]
        with tempfile.TemporaryDirectory() as folder:
            model, page = Path(folder) / f"{name}.json", Path(folder) / f"{name}.html"
            fit = [program, "fit", data / log, "--profile", name, "-o", model, "--report", page]
            if subprocess.run(fit).returncode not in (0, 3):  # 3: the verdict is unusable
                sys.exit(f"{name}: no fit")
            text = page.read_text()
            sections = text.split('<section id="')[1:]
            ids = [own.split('"')[0] for own in sections if own.split("<h2>")[1].startswith(PARTS)]
            shown = ", ".join(f"#{own}" for own in ids)
            style = f"<style>{HIDDEN} {shown} {SHOWN}</style></head>"
            page.write_text(text.replace("</head>", style, 1))
            picture = ROOT / "docs" / "images" / f"{name}.png"
            options = ["--headless", "--no-sandbox", "--hide-scrollbars"]
            size = [f"--window-size={WIDTH},{height}", "--virtual-time-budget=4000"]
            shot = [browser, *options, *size, f"--screenshot={picture}", page.as_uri()]
            subprocess.run(shot, check=True, stderr=subprocess.DEVNULL)
            print(picture)


if __name__ == "__main__":
    main()
