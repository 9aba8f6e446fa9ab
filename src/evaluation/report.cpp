// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tables as files: CSV, plots and Markdown.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "cloud_colorizer/base/check.hpp"
#include "evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

/// What the paper (Cho, Yan, Matsushita, Byun, 3DV 2014) tells of its own runs, as far as it is known to us.
const char* const kPaperFigures =
    "The paper's own figures (Cho et al., 3DV 2014; SuiteSparseQR on 16 cores): 117 s for 0.89 M points, 2.92 h for "
    "216 M points, 4.49 neighbours a node for four passes. The size of its noise is not known, so its errors cannot be "
    "compared with ours number by number; what can be compared is the order of the methods and the ratios of time.\n";

const std::vector<std::string> kNoises = {"both", "extrinsics", "intensities"};

/// Different values of a column, in their order.
std::vector<std::string> valuesOf(const Table& table, const std::string& column) {
  std::vector<std::string> values;
  std::set<std::string> known;
  for (const auto& row : table.rows) {
    if (known.insert(row[table.column(column)]).second) values.push_back(row[table.column(column)]);
  }
  return values;
}

/// Mean over the meshes of a column, by method and kind of noise, for the plot.
Table meanByMethod(const Table& table1, const std::string& column) {
  Table means{{"method"}, {}};
  means.header.insert(means.header.end(), kNoises.begin(), kNoises.end());
  for (const std::string& method : valuesOf(table1, "method")) {
    if (method.find(" plain") != std::string::npos) continue;
    std::vector<std::string> row = {method};
    for (const std::string& noise : kNoises) {
      const Table chosen = table1.where("method", method).where("noise", noise).where("status", "ok");
      double sum = 0;
      for (const auto& cells : chosen.rows) sum += std::stod(cells[chosen.column(column)]);
      row.push_back(chosen.rows.empty() ? "" : formatNumber(sum / static_cast<double>(chosen.rows.size()), 3));
    }
    means.add(row);
  }
  return means;
}

/// One row a method, with the errors of the three kinds of noise side by side.
Table byNoise(const Table& one_mesh) {
  Table wide{{"method"}, {}};
  for (const std::string& noise : kNoises) {
    for (const std::string what : {" AEP", " REP"}) wide.header.push_back(noise + what);
  }
  for (const std::string name :
       {"both AEP after gain", "both CIEDE2000", "both PSNR", "neighbours", "no anchor %", "s"}) {
    wide.header.push_back(name);
  }
  for (const std::string& method : valuesOf(one_mesh, "method")) {
    const Table rows = one_mesh.where("method", method);
    const auto cell = [&rows](const std::string& noise, const std::string& column) {
      const Table row = rows.where("noise", noise);
      return row.rows.empty() ? std::string("-") : row.rows[0][row.column(column)];
    };
    std::vector<std::string> line = {method};
    for (const std::string& noise : kNoises) {
      const std::string status = cell(noise, "status");
      line.push_back(status == "ok" ? cell(noise, "aep") : status);
      line.push_back(cell(noise, "rep"));
    }
    for (const std::string column : {"aep_gain", "ciede2000", "psnr", "neighbours", "unanchored_percent", "seconds"}) {
      line.push_back(cell("both", column));
    }
    wide.add(line);
  }
  return wide;
}

/// A cell of table 2 where the row ended in time, else what stopped it.
std::string resultOf(const Table& table2, const std::string& graph, const std::string& solver, const std::string& size,
                     const std::string& column) {
  const Table row = table2.where("points", size).where("graph", graph).where("solver", solver);
  if (row.rows.empty()) return "";
  const std::string& status = row.rows[0][row.column("status")];
  return status == "ok" ? row.rows[0][row.column(column)] : status;
}

/// Total seconds by size, one column a graph and solver that ended in time at least once: for the plot.
Table timeBySize(const Table& table2) {
  Table times{{"points"}, {}};
  std::vector<std::pair<std::string, std::string>> series;
  const Table ok = table2.where("status", "ok");  // gnuplot warns of a series without a point
  for (const auto& row : ok.rows) {
    const std::pair<std::string, std::string> one{row[ok.column("graph")], row[ok.column("solver")]};
    if (std::find(series.begin(), series.end(), one) == series.end()) series.push_back(one);
  }
  for (const auto& [graph, solver] : series) times.header.push_back(graph + " " + solver);
  for (const std::string& size : valuesOf(table2, "points")) {
    std::vector<std::string> row = {size};
    for (const auto& [graph, solver] : series) row.push_back(resultOf(ok, graph, solver, size, "total_s"));
    times.add(row);
  }
  return times;
}

/// Seconds and peak memory, one column a size.
Table secondsAndMemory(const Table& table2) {
  const std::vector<std::string> sizes = valuesOf(table2, "points");
  Table wide{{"graph", "solver", "neighbours"}, {}};
  for (const std::string& size : sizes) wide.header.push_back(size);
  for (const std::string& graph : valuesOf(table2, "graph")) {
    for (const std::string& solver : valuesOf(table2, "solver")) {
      std::vector<std::string> row = {graph, solver, resultOf(table2, graph, solver, sizes.front(), "neighbours")};
      for (const std::string& size : sizes) {
        const std::string seconds = resultOf(table2, graph, solver, size, "total_s");
        const bool ok = !table2.where("points", size)
                             .where("graph", graph)
                             .where("solver", solver)
                             .where("status", "ok")
                             .rows.empty();
        row.push_back(ok ? seconds + " s, " + resultOf(table2, graph, solver, size, "peak_mb") + " MB" : seconds);
      }
      wide.add(row);
    }
  }
  return wide;
}

/// The rows of the size nearest to the 0.98 M points that the paper's comparison is about.
Table stages(const Table& table2) {
  std::string best;
  for (const std::string& size : valuesOf(table2, "points")) {
    const auto distance = [](const std::string& text) { return std::abs(std::log(std::stod(text) / 980000)); };
    if (best.empty() || distance(size) < distance(best)) best = size;
  }
  return table2.where("points", best);
}

void tryPlot(const std::string& directory, const std::string& name, const std::string& script,
             std::vector<std::string>& messages) {
  std::string message;
  if (!plot(directory, name, script, &message)) messages.push_back(message);
}

void plotErrors(const std::string& directory, const Table& table1, std::vector<std::string>& messages) {
  for (const std::string column : {"aep", "rep"}) {
    const std::string name = "error_" + column;
    writeText(directory + "/" + name + ".csv", csv(meanByMethod(table1, column)));
    tryPlot(directory, name,
            "set style data histograms\nset style histogram clustered gap 1\nset style fill solid 0.8\n"
            "set xtics rotate by -35\nset ylabel '" +
                std::string(column == "aep" ? "AEP" : "REP") +
                ", mean over the meshes'\nset key outside top horizontal\nset yrange [0:]\nplot for [i=2:4] '" + name +
                ".csv' using i:xtic(1) title columnheader(i)",
            messages);
  }
}

void plotTimes(const std::string& directory, const Table& table2, std::vector<std::string>& messages) {
  const Table times = timeBySize(table2);
  writeText(directory + "/time_by_size.csv", csv(times));
  // A colour a graph, a kind of line a solver.
  static const std::map<std::string, std::string> kLines = {
      {"CG", "1 pt 7"}, {"CHOLMOD", "3 pt 5"}, {"SuiteSparseQR", "2 pt 6"}};
  std::string script =
      "set logscale xy\nset xlabel 'points'\nset ylabel 'processor seconds'\nset key outside\nset format x '10^{%T}'\n"
      "set xrange [3e4:4e8]\n$paper << EOD\n890000,117\n216000000,10512\nEOD\nplot ";
  const std::vector<std::string> graphs = valuesOf(table2, "graph");
  for (std::size_t column = 1; column < times.header.size(); ++column) {
    const std::string& name = times.header[column];
    const std::size_t space = name.rfind(' ');
    const auto graph = std::find(graphs.begin(), graphs.end(), name.substr(0, space));
    script += "'time_by_size.csv' using 1:" + std::to_string(column + 1) + " with linespoints lw 2 lc " +
              std::to_string(graph - graphs.begin() + 1) + " dt " + kLines.at(name.substr(space + 1)) + " title '" +
              name + "', ";
  }
  tryPlot(directory, "time_by_size",
          script + "$paper using 1:2 with points pt 3 ps 2 lc 'red' title 'the paper, 16 cores'", messages);
}

std::string table1Text(const Table& table1, const std::string& run) {
  std::string text = run +
                     "AEP: mean absolute error over points and channels (of 255). REP: share of points with a mean "
                     "channel error above 20. \"plain\": parts of the graph without an anchor are left as the "
                     "equations leave them. s: processor seconds from the observations to the colours (both kinds of "
                     "noise); for `default` with the alignment and a second observation.\n";
  for (const std::string& mesh : valuesOf(table1, "mesh")) {
    text += "\n**" + mesh + "**\n\n" + markdown(byNoise(table1.where("mesh", mesh)));
  }
  return text;
}

std::string table2Text(const Table& table2, const std::string& run) {
  return run + kPaperFigures + "\nProcessor seconds and peak memory:\n\n" + markdown(secondsAndMemory(table2)) +
         "\nBy stage:\n\n" + markdown(stages(table2));
}

std::string barsText(const Tables& tables) {
  std::string text;
  for (const std::string& bar : checkBars(tables)) text += "* " + bar + "\n";
  return text;
}

std::string describeMachine() {
  std::string model = "unknown processor", line;
  std::ifstream cpu("/proc/cpuinfo");
  while (std::getline(cpu, line)) {
    if (line.rfind("model name", 0) == 0) model = line.substr(line.find(':') + 2);
  }
  const double bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return model + ", " + std::to_string(sysconf(_SC_NPROCESSORS_ONLN)) + " cores, " + formatNumber(bytes / 1e9, 0) +
         " GB";
}

}  // namespace

Table growthOf(const Table& table2) {
  Table growth{{"graph", "solver", "from", "to", "us_per_point_from", "us_per_point_to", "exponent"}, {}};
  for (const std::string& graph : valuesOf(table2, "graph")) {
    for (const std::string& solver : valuesOf(table2, "solver")) {
      const Table rows = table2.where("graph", graph).where("solver", solver).where("status", "ok");
      if (rows.rows.size() < 2) continue;
      const auto number = [&rows](std::size_t row, const std::string& column) {
        return std::stod(rows.rows[row][rows.column(column)]);
      };
      const std::size_t last = rows.rows.size() - 1;
      const double exponent = std::log(number(last, "total_s") / number(0, "total_s")) /
                              std::log(number(last, "points") / number(0, "points"));
      growth.add({graph, solver, rows.rows[0][rows.column("points")], rows.rows[last][rows.column("points")],
                  rows.rows[0][rows.column("us_per_point")], rows.rows[last][rows.column("us_per_point")],
                  formatNumber(exponent, 2)});
    }
  }
  return growth;
}

std::string describeRun(const std::string& command) {
  return "Command: `" + command + "`\n\nMachine: " + describeMachine() + "\n\n";
}

std::vector<std::string> writeTables(const std::string& directory, const Tables& tables, const std::string& command) {
  makeDirectory(directory);
  const std::string run = describeRun(command);
  const cv::Mat& closeup = tables.table1.closeup;
  require(closeup.empty() || cv::imwrite(directory + "/closeups.png", closeup), "cannot write ", directory,
          "/closeups.png");
  std::vector<std::string> messages;
  std::string all = "# The paper's tables\n";
  const auto write = [&](const std::string& name, const std::string& text) {
    writeText(directory + "/" + name + ".md", text);
    all += "\n## " + name + "\n\n" + text;
  };
  const auto writeTable = [&](const std::string& name, const Table& table, const std::function<std::string()>& text) {
    if (table.rows.empty()) return;
    writeText(directory + "/" + name + ".csv", csv(table));
    write(name, text());
  };
  writeTable("table1", tables.table1.table, [&] {
    plotErrors(directory, tables.table1.table, messages);
    return table1Text(tables.table1.table, run);
  });
  writeTable("density", tables.density, [&] { return markdown(tables.density); });
  writeTable("isolated", tables.isolated, [&] { return markdown(tables.isolated); });
  writeTable("table2", tables.table2, [&] {
    plotTimes(directory, tables.table2, messages);
    write("growth", markdown(growthOf(tables.table2)));
    return table2Text(tables.table2, run);
  });
  write("bars", barsText(tables));
  writeText(directory + "/TABLES.md", all);
  return messages;
}

std::vector<std::string> writeAblations(const std::string& directory, const Table& ablations,
                                        const std::string& command) {
  makeDirectory(directory);
  std::vector<std::string> messages;
  writeText(directory + "/ablations.csv", csv(ablations));
  for (const std::string& what : valuesOf(ablations, "what")) {
    const Table rows = ablations.where("what", what);
    Table wide{{"value", "both", "intensities", "seam"}, {}};
    for (const std::string& value : valuesOf(rows, "value")) {
      const Table both = rows.where("value", value).where("noise", "both");
      const Table intensities = rows.where("value", value).where("noise", "intensities");
      wide.add({value, both.rows[0][both.column("aep")], intensities.rows[0][both.column("aep")],
                both.rows[0][both.column("seam")]});
    }
    const std::string name = "ablation_" + what;
    const bool seam = what == "overlap_percent";
    writeText(directory + "/" + name + ".csv", csv(wide));
    tryPlot(directory, name,
            "set terminal pngcairo size 520,360 font 'sans,10'\nset output '" + name +
                ".png'\nset style data linespoints\nset xlabel '" + what + "' noenhanced\nset ylabel '" +
                (seam ? "seam, of 255" : "AEP") + "'\nset yrange [0:]\nset key bottom\n" +
                (seam ? "plot '" + name + ".csv' using 0:4:xtic(1) every ::1 lw 2 pt 7 title 'at the borders of chunks'"
                      : "plot '" + name + ".csv' using 0:2:xtic(1) every ::1 lw 2 pt 7 title 'both kinds of noise', " +
                            "'' using 0:3 every ::1 lw 2 pt 7 title 'intensities alone'"),
            messages);
  }
  const std::string text = describeRun(command) + markdown(ablations);
  writeText(directory + "/ablations.md", text);
  return messages;
}

}  // namespace cloud_colorizer
