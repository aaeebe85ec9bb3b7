"""Pictures of the reports of real arms, for README.md and the documents.

    TORQUEWISE_SHARED=FOLDER python benches/pictures.py

FOLDER/data holds the public logs that profiles/ names. The program is `torquewise` on the path or what
TORQUEWISE names, the browser `chromium` or what TORQUEWISE_CHROMIUM names. Writes docs/images/NAME.png.
"""

import os
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOGS = {"ur10": "ur10_panda_unisa/ur10_exciting_trajectory.db3"}  # name of the profile, log
PARTS = ("Torque", "Geometry")  # sections that are shown, of the whole report
HIDDEN = "nav, header, details, .caption, section { display: none !important }"
SHOWN = "{ display: block !important }"
WIDTH, HEIGHT = 1100, 1540


def main():
    program = os.environ.get("TORQUEWISE", "torquewise")
    browser = os.environ.get("TORQUEWISE_CHROMIUM", "chromium")
    data = Path(os.environ["TORQUEWISE_SHARED"]) / "data"
    for name, log in LOGS.items():
        with tempfile.TemporaryDirectory() as folder:
            model, page = Path(folder) / f"{name}.json", Path(folder) / f"{name}.html"
            fit = [program, "fit", data / log, "--profile", name, "-o", model, "--report", page]
            subprocess.run(fit, check=True)
            text = page.read_text()
            sections = text.split('<section id="')[1:]
            ids = [own.split('"')[0] for own in sections if own.split("<h2>")[1].startswith(PARTS)]
            shown = ", ".join(f"#{own}" for own in ids)
            style = f"<style>{HIDDEN} {shown} {SHOWN}</style></head>"
            page.write_text(text.replace("</head>", style, 1))
            picture = ROOT / "docs" / "images" / f"{name}.png"
            options = ["--headless", "--no-sandbox", "--hide-scrollbars"]
            size = [f"--window-size={WIDTH},{HEIGHT}", "--virtual-time-budget=4000"]
            shot = [browser, *options, *size, f"--screenshot={picture}", page.as_uri()]
            subprocess.run(shot, check=True, stderr=subprocess.DEVNULL)
            print(picture)


if __name__ == "__main__":
    main()
