"""Plots as SVG, by gnuplot."""

import subprocess

from page import need_gnuplot


def plot(folder, name, *, x, y, series, log="", style="linespoints"):
    """Writes folder/name: `series` is a list of (title, [(x, y), ...]).

    log: the axes that are logarithmic, such as "x" or "xy".
    """
    need_gnuplot()
    script = [f'set terminal svg size 800,450 font "sans,14" background "white"',
              f'set output "{folder / name}"', f'set xlabel "{x}"', f'set ylabel "{y}"',
              "set grid", "set key outside below"]
    script += [f"set logscale {log}"] if log else []
    script += ["set yrange [0:*]"] if "y" not in log else []
    if style == "histogram":
        script += ["set style data histogram", "set style fill solid 0.8", "set boxwidth 0.9",
                   "set xtics rotate by -25"]
    parts = []
    for number, (title, points) in enumerate(series):
        script.append(f"$data{number} << END")
        script += [f'"{a}" {b}' if style == "histogram" else f"{a} {b}" for a, b in points]
        script.append("END")
        parts.append(f'$data{number} using 2:xtic(1) title "{title}"' if style == "histogram" else
                     f'$data{number} using 1:2 with {style} title "{title}"')
    script.append("plot " + ", ".join(parts))
    done = subprocess.run(["gnuplot"], input="\n".join(script) + "\n", text=True, check=False,
                          capture_output=True)
    if done.returncode != 0 or not (folder / name).exists():
        raise SystemExit(f"evaluate: gnuplot on {name}: {done.stderr}")
    return name
