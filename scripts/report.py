#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""The CSV files of `evaluate` as Markdown, plots and sentences about the bars that they must meet.

    scripts/report.py DIR [COMMAND]

DIR is the --output of `evaluate tables`, `ablations` or `heldout`; COMMAND is told in the text as what made the files.
Of what is there: table1, table2, density, isolated, growth, bars, ablations, heldout as .md, all tables as TABLES.md,
and plots as .png beside the .gp and .csv that they are made of, if there is a gnuplot (Debian: gnuplot-nox).
Prints the bars and how many are missed.
"""
import csv
import math
import os
import pathlib
import subprocess
import sys

NOISES = ["both", "extrinsics", "intensities"]
TABLE1_WORDS = """\
AEP: mean absolute error over points and channels (of 255). REP: share of points with a mean channel error above 20. \
"plain": parts of the graph without an anchor are left as the equations leave them. s: processor seconds from the \
observations to the colours (both kinds of noise); for `default` with the alignment and a second observation.
"""
PAPER_WORDS = """\
The paper's own figures (Cho et al., 3DV 2014; SuiteSparseQR on 16 cores): 117 s for 0.89 M points, 2.92 h for \
216 M points, 4.49 neighbours a node for four passes. The size of its noise is not known, so its errors cannot be \
compared with ours number by number; what can be compared is the order of the methods and the ratios of time.
"""


# ---- tables: a list of rows, each a dictionary by column; a header is a list of columns ----------------------------
def read(path):
    """The rows of a CSV file; none where there is no file."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            raise ValueError(f"{path}: row {number} has {len(row)} cells under a header of {len(header)}")
    return [dict(zip(header, row)) for row in rows]


def write(path, header, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])


def markdown(rows, header=None):
    """Rows as dictionaries, or as lists below a header."""
    if header is None:
        header, rows = list(rows[0]), [list(row.values()) for row in rows]
    lines = ["| " + " | ".join(cells) + " |" for cells in [header, *rows]]
    return "\n".join([lines[0], "|" + "---|" * len(header), *lines[1:]]) + "\n"


def where(rows, **cells):
    return [row for row in rows if all(row[column] == value for column, value in cells.items())]


def values_of(rows, column):
    """Different values of a column, in their order."""
    return list(dict.fromkeys(row[column] for row in rows))


def number(text):
    """NaN for "-"."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def fixed(value, digits):
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def ratio(a, b):
    """As the numbers of the processor: a time can be too short for its clock."""
    return a / b if b else math.inf if a > 0 else math.nan


# ---- plots ---------------------------------------------------------------------------------------------------------
def plot(folder, name, script):
    """Makes NAME.png by NAME.gp; what went wrong, or nothing."""
    (folder / f"{name}.gp").write_text(
        f"set terminal pngcairo size 1100,700 font 'sans,12'\nset output '{name}.png'\nset datafile separator ','\n"
        f"set grid\nset style line 1 lw 2\n{script}\n")
    try:
        code = subprocess.run(["gnuplot", f"{name}.gp"], cwd=folder, check=False).returncode
    except FileNotFoundError:
        return f"gnuplot is not installed (Debian: gnuplot-nox); {name} has its CSV only"
    return f"gnuplot failed on {folder}/{name}.gp" if code else ""


def plot_errors(folder, table1):
    for column in "aep", "rep":
        rows = []
        for method in values_of(table1, "method"):
            means = []
            for noise in NOISES:
                cells = [float(row[column]) for row in where(table1, method=method, noise=noise, status="ok")]
                means.append(fixed(sum(cells) / len(cells), 3) if cells else "")
            if " plain" not in method:
                rows.append([method, *means])
        write(folder / f"error_{column}.csv", ["method", *NOISES], rows)
        yield plot(folder, f"error_{column}",
                   "set style data histograms\nset style histogram clustered gap 1\nset style fill solid 0.8\n"
                   f"set xtics rotate by -35\nset ylabel '{column.upper()}, mean over the meshes'\n"
                   "set key outside top horizontal\nset yrange [0:]\n"
                   f"plot for [i=2:4] 'error_{column}.csv' using i:xtic(1) title columnheader(i)")


def plot_times(folder, table2):
    ok = where(table2, status="ok")  # gnuplot warns of a series without a point
    series = list(dict.fromkeys((row["graph"], row["solver"]) for row in ok))
    seconds = {(row["points"], row["graph"], row["solver"]): row["total_s"] for row in ok}
    write(folder / "time_by_size.csv", ["points", *map(" ".join, series)],
          [[size, *(seconds.get((size, *one), "") for one in series)] for size in values_of(table2, "points")])
    dashes = {"CG": "1 pt 7", "CHOLMOD": "3 pt 5", "SuiteSparseQR": "2 pt 6"}  # a colour a graph, a dash a solver
    graphs = values_of(table2, "graph")
    lines = [f"'time_by_size.csv' using 1:{column} with linespoints lw 2 lc {graphs.index(graph) + 1} "
             f"dt {dashes[solver]} title '{graph} {solver}'" for column, (graph, solver) in enumerate(series, 2)]
    lines.append("$paper using 1:2 with points pt 3 ps 2 lc 'red' title 'the paper, 16 cores'")
    yield plot(folder, "time_by_size",
               "set logscale xy\nset xlabel 'points'\nset ylabel 'processor seconds'\nset key outside\n"
               "set format x '10^{%T}'\nset xrange [3e4:4e8]\n$paper << EOD\n890000,117\n216000000,10512\nEOD\n"
               "plot " + ", ".join(lines))


def plot_ablations(folder, ablations):
    for what in values_of(ablations, "what"):
        name, rows = f"ablation_{what}", []
        for value in values_of(where(ablations, what=what), "value"):
            both, intensities = (where(ablations, what=what, value=value, noise=noise)[0]
                                 for noise in ("both", "intensities"))
            rows.append([value, both["aep"], intensities["aep"], both["seam"]])
        write(folder / f"{name}.csv", ["value", "both", "intensities", "seam"], rows)
        lines = [f"'{name}.csv' using 0:2:xtic(1) every ::1 lw 2 pt 7 title 'both kinds of noise'",
                 "'' using 0:3 every ::1 lw 2 pt 7 title 'intensities alone'"]
        if what == "overlap_percent":
            lines = [f"'{name}.csv' using 0:4:xtic(1) every ::1 lw 2 pt 7 title 'at the borders of chunks'"]
        yield plot(folder, name,
                   f"set terminal pngcairo size 520,360 font 'sans,10'\nset output '{name}.png'\n"
                   f"set style data linespoints\nset xlabel '{what}' noenhanced\n"
                   f"set ylabel '{'seam, of 255' if what == 'overlap_percent' else 'AEP'}'\n"
                   "set yrange [0:]\nset key bottom\nplot " + ", ".join(lines))


# ---- text ----------------------------------------------------------------------------------------------------------
def describe_run(command):
    model = "unknown processor"
    for line in pathlib.Path("/proc/cpuinfo").read_text(errors="replace").splitlines():
        if line.startswith("model name"):
            model = line.split(": ", 1)[1]
    gigabytes = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1e9
    machine = f"Machine: {model}, {os.cpu_count()} cores, {gigabytes:.0f} GB\n\n"
    return (f"Command: `{command}`\n\n" if command else "") + machine


def table1_text(table1):
    header = ["method", *(f"{noise} {what}" for noise in NOISES for what in ("AEP", "REP")), "both AEP after gain",
              "both CIEDE2000", "both PSNR", "neighbours", "no anchor %", "s"]
    text = TABLE1_WORDS
    for mesh in values_of(table1, "mesh"):
        lines = []
        for method in values_of(where(table1, mesh=mesh), "method"):
            rows = {row["noise"]: row for row in where(table1, mesh=mesh, method=method)}
            line = [method]
            for noise in NOISES:
                row = rows.get(noise, {"status": "-", "rep": "-"})
                line += [row["aep"] if row["status"] == "ok" else row["status"], row["rep"]]
            columns = "aep_gain", "ciede2000", "psnr", "neighbours", "unanchored_percent", "seconds"
            lines.append(line + [rows.get("both", {}).get(column, "-") for column in columns])
        text += f"\n**{mesh}**\n\n" + markdown(lines, header)
    return text


def table2_text(table2):
    sizes, lines = values_of(table2, "points"), []
    for graph in values_of(table2, "graph"):
        for solver in values_of(table2, "solver"):
            rows = {row["points"]: row for row in where(table2, graph=graph, solver=solver)}
            cells = [f"{row['total_s']} s, {row['peak_mb']} MB" if row["status"] == "ok" else row["status"]
                     for row in (rows.get(size, {"status": ""}) for size in sizes)]
            first = rows.get(sizes[0], {"status": ""})
            lines.append([graph, solver, first["neighbours"] if first["status"] == "ok" else first["status"], *cells])
    # By stage: the size nearest to the 0.98 M points that the paper's comparison is about.
    nearest = min(sizes, key=lambda size: abs(math.log(float(size) / 980000)))
    return (PAPER_WORDS + "\nProcessor seconds and peak memory:\n\n" +
            markdown(lines, ["graph", "solver", "neighbours", *sizes]) + "\nBy stage:\n\n" +
            markdown(where(table2, points=nearest)))


def growth_of(table2):
    """How the time grows, of the rows that ended in time at two sizes or more: x of "time ~ points^x"."""
    growth = []
    for graph in values_of(table2, "graph"):
        for solver in values_of(table2, "solver"):
            rows = where(table2, graph=graph, solver=solver, status="ok")
            if len(rows) < 2:
                continue
            first, last = rows[0], rows[-1]
            times = ratio(float(last["total_s"]), float(first["total_s"]))
            exponent = math.nan if not 0 < times < math.inf else (
                math.log(times) / math.log(float(last["points"]) / float(first["points"])))
            growth.append({"graph": graph, "solver": solver, "from": first["points"], "to": last["points"],
                           "us_per_point_from": first["us_per_point"], "us_per_point_to": last["us_per_point"],
                           "exponent": fixed(exponent, 2)})
    return growth


# ---- the bars: one sentence each with its numbers --------------------------------------------------------------------
def sentence(met, text):
    return ("met: " if met else "MISSED: ") + text


def method_bars(table1):
    """Of one mesh and kind of noise: four passes against the 20 nearest neighbours, `default` against all others."""
    for name in dict.fromkeys((row["mesh"], row["noise"]) for row in table1):
        rows = {row["method"]: row for row in where(table1, mesh=name[0], noise=name[1])}
        aep = {method: number(row["aep"]) for method, row in rows.items()}
        ours, other = aep["4-pass"], aep["20-NN"]
        times = ratio(number(rows["20-NN"]["seconds"]), number(rows["4-pass"]["seconds"]))
        stopped = math.isnan(other)  # then only the time can be compared
        yield sentence((stopped or ours <= 1.05 * other) and times > 3,
                       f"{', '.join(name)}: 4-pass AEP {fixed(ours, 2)}, 20-NN {fixed(other, 2)}"
                       f"{' (stopped at the limit)' if stopped else ''}; 20-NN takes {fixed(times, 1)} times as long")
        others = {method: value for method, value in aep.items() if method != "default" and not math.isnan(value)}
        best = min(sorted(others), key=others.get)
        yield sentence(aep["default"] <= 1.02 * others[best],
                       f"{', '.join(name)}: default AEP {fixed(aep['default'], 2)}, best other row {best} "
                       f"{fixed(others[best], 2)}")


def density_bars(density):
    """Four passes against the 20 nearest neighbours at other numbers of points."""
    for row in density:
        ours, other = number(row["4-pass"]), number(row["20-NN"])
        if not math.isnan(other):  # else it ran into the limit
            yield sentence(ours <= 1.05 * other, f"{row['mesh']}, intensities, {row['points']} points: "
                           f"4-pass AEP {fixed(ours, 2)}, 20-NN {fixed(other, 2)}")


def isolated_bars(isolated):
    """The paper's failure: where the points are no uniform samples, 5-NN has parts without an anchor."""
    for row in isolated:
        if row["graph"] != "5-NN" or row["sampling"] == "uniform":
            continue
        share, plain, anchored = number(row["unanchored_percent"]), number(row["plain_aep"]), number(row["aep"])
        yield sentence(share > 0 and plain > anchored,
                       f"{row['sampling']}: 5-NN leaves {fixed(share, 3)} % of the points without an anchor: AEP "
                       f"{fixed(plain, 2)}, with our rule {fixed(anchored, 2)}")


def speed_bars(table2):
    """Four passes against the slower ways, of as many points."""
    seconds = {(row["points"], row["graph"], row["solver"]): number(row["total_s"])
               for row in where(table2, status="ok")}
    for points in sorted(values_of(table2, "points"), key=int):
        for graph, solver in ("4-pass", "CG"), ("4-pass shared", "CHOLMOD"):
            ours = seconds.get((points, graph, solver))
            if ours is None:
                continue
            for other, factor in ("20-NN", 20), (graph, 3):
                theirs = seconds.get((points, other, "SuiteSparseQR"))
                result = "was stopped at the limit" if theirs is None else (
                    f"{fixed(theirs, 2)} s, {fixed(ratio(theirs, ours), 1)} times as long")
                yield sentence(theirs is None or theirs >= factor * ours,
                               f"{points} points: {graph} with {solver} {fixed(ours, 2)} s; {other} with SuiteSparseQR "
                               f"{result} (at least {factor} asked for)")


def check_bars(tables):
    return [*method_bars(tables["table1"]), *density_bars(tables["density"]), *isolated_bars(tables["isolated"]),
            *speed_bars(tables["table2"])]


# ---- the program -----------------------------------------------------------------------------------------------------
def report_tables(folder, tables, run):
    """Markdown and plots; the sentences of the bars."""
    texts = {"table1": lambda rows: run + table1_text(rows), "density": markdown, "isolated": markdown,
             "growth": markdown, "table2": lambda rows: run + table2_text(rows)}
    texts = {name: text(tables[name]) for name, text in texts.items() if tables[name]}
    bars = check_bars(tables)
    texts["bars"] = "".join(f"* {bar}\n" for bar in bars)
    for name, text in texts.items():
        (folder / f"{name}.md").write_text(text)
    (folder / "TABLES.md").write_text("# The paper's tables\n" +
                                      "".join(f"\n## {name}\n\n{text}" for name, text in texts.items()))
    return bars


def main(folder, command=""):
    folder, run = pathlib.Path(folder), describe_run(command)
    tables = {name: read(folder / f"{name}.csv")
              for name in ("table1", "table2", "density", "isolated", "ablations", "heldout")}
    if not any(tables.values()):
        sys.exit(f"{folder} has no table of `evaluate` (table1.csv, ...)")
    tables["growth"] = growth_of(tables["table2"])
    for name in "ablations", "heldout":
        if tables[name]:
            (folder / f"{name}.md").write_text(run + markdown(tables[name]))
            print(f"wrote {folder}/{name}.md")
    plots = [*plot_errors(folder, tables["table1"])] if tables["table1"] else []
    plots += plot_times(folder, tables["table2"]) if tables["table2"] else []
    plots += plot_ablations(folder, tables["ablations"])
    for problem in filter(None, plots):
        print("warning:", problem, file=sys.stderr)
    if any(tables[name] for name in ("table1", "table2", "density", "isolated")):
        bars = report_tables(folder, tables, run)
        print(*bars, f"{sum(bar.startswith('MISSED') for bar in bars)} of {len(bars)} bars missed", sep="\n")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3) or sys.argv[1].startswith("-"):
        print(__doc__)
        sys.exit(0 if sys.argv[1:2] == ["--help"] else 2)
    main(*sys.argv[1:])
