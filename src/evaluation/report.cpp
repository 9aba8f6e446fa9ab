// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The tables as files: CSV, plots and Markdown.
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "cloud_colorizer/check.hpp"
#include "cloud_colorizer/evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

/// What the paper (Cho, Yan, Matsushita, Byun, 3DV 2014) tells of its own runs, as far as it is known to us.
const char* const kPaperFigures =
    "The paper's own figures (Cho et al., 3DV 2014; SuiteSparseQR on 16 cores): 117 s for 0.89 M points, 2.92 h for "
    "216 M points, 4.49 neighbours a node for four passes. Its noise sizes are not known, so its errors cannot be "
    "compared with ours number by number; what can be compared is the order of the methods and the ratios of time. "
    "Our passes on closed surfaces share more links, so we count about 4.0 neighbours.\n";

std::string describeRun(const std::string& command) {
  return "Command: `" + command + "`\n\nMachine: " + describeMachine() + "\n\n";
}

/// Mean over the meshes of a column, by method and kind of noise, for the plot.
Table meanByMethod(const Table& table1, const std::string& column) {
  Table means{{"method", "both", "extrinsics", "intensities"}, {}};
  std::vector<std::string> methods;
  std::set<std::string> known;
  for (const auto& row : table1.rows) {
    if (known.insert(row[table1.column("method")]).second) methods.push_back(row[table1.column("method")]);
  }
  for (const std::string& method : methods) {
    std::vector<std::string> row = {method};
    for (const std::string noise : {"both", "extrinsics", "intensities"}) {
      const Table chosen = table1.where("method", method).where("noise", noise).where("status", "ok");
      double sum = 0;
      for (const auto& cells : chosen.rows) sum += std::stod(cells[chosen.column(column)]);
      row.push_back(chosen.rows.empty() ? "" : formatNumber(sum / static_cast<double>(chosen.rows.size()), 3));
    }
    means.add(row);
  }
  return means;
}

/// Total seconds by size, one column a graph and solver.
Table timeBySize(const Table& table2) {
  Table times{{"points"}, {}};
  std::vector<std::pair<std::string, std::string>> series;
  std::vector<std::string> sizes;
  for (const auto& row : table2.rows) {
    const std::pair<std::string, std::string> one{row[table2.column("graph")], row[table2.column("solver")]};
    const bool ok = row[table2.column("status")] == "ok";  // gnuplot warns of a series without a point
    if (ok && std::find(series.begin(), series.end(), one) == series.end()) series.push_back(one);
    const std::string& size = row[table2.column("points")];
    if (std::find(sizes.begin(), sizes.end(), size) == sizes.end()) sizes.push_back(size);
  }
  for (const auto& [graph, solver] : series) times.header.push_back(graph + " " + solver);
  for (const std::string& size : sizes) {
    std::vector<std::string> row = {size};
    for (const auto& [graph, solver] : series) {
      const Table cell = table2.where("points", size).where("graph", graph).where("solver", solver);
      const bool ok = !cell.rows.empty() && cell.rows[0][cell.column("status")] == "ok";
      row.push_back(ok ? cell.rows[0][cell.column("total_s")] : "");
    }
    times.add(row);
  }
  return times;
}

void tryPlot(const std::string& directory, const std::string& name, const std::string& script,
             std::vector<std::string>& messages) {
  std::string message;
  if (!plot(directory, name, script, &message)) messages.push_back(message);
}

void plotTables(const std::string& directory, const Table& table1, const Table& table2,
                std::vector<std::string>& messages) {
  for (const std::string column : {"aep", "rep"}) {
    const std::string name = "error_" + column;
    writeText(directory + "/" + name + ".csv", csv(meanByMethod(table1, column)));
    tryPlot(
        directory, name,
        "set style data histograms\nset style histogram clustered gap 1\nset style fill solid 0.8\nset yrange [0:*]\n"
        "set xtics rotate by -35\nset ylabel '" +
            std::string(column == "aep" ? "AEP" : "REP") + ", mean over the meshes'\nplot for [i=2:4] '" + name +
            ".csv' using i:xtic(1) title columnheader(i)",
        messages);
  }
  const Table times = timeBySize(table2);
  writeText(directory + "/time_by_size.csv", csv(times));
  tryPlot(directory, "time_by_size",
          "set logscale xy\nset xlabel 'points'\nset ylabel 'seconds'\nset key outside\n"
          "$paper << EOD\n890000,117\n216000000,10512\nEOD\n"
          "plot for [i=2:" +
              std::to_string(times.header.size()) +
              "] 'time_by_size.csv' using 1:i with linespoints title columnheader(i), "
              "$paper using 1:2 with points pt 3 ps 2 title 'the paper, 16 cores'",
          messages);
}

}  // namespace

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

std::vector<std::string> writeTables(const std::string& directory, const Table1& table1, const Table& table2,
                                     const std::string& command) {
  makeDirectory(directory);
  std::vector<std::string> messages;
  writeText(directory + "/table1.csv", csv(table1.table));
  writeText(directory + "/table2.csv", csv(table2));
  if (!table1.closeup.empty()) {
    require(cv::imwrite(directory + "/closeups.png", table1.closeup), "cannot write ", directory, "/closeups.png");
  }
  plotTables(directory, table1.table, table2, messages);
  std::string text = "# Tables 1 and 2\n\n" + describeRun(command) + kPaperFigures;
  text +=
      "\n## Table 1: error by method and noise\n\nAEP: mean absolute error over points and channels (of 255). REP: "
      "share of points with a mean channel error above 20. \"plain\": parts of the graph without an anchor are "
      "left as the equations leave them. Seconds: from the observations to the colours; for `default` with the "
      "alignment and a second observation.\n\n";
  text += markdown(
      table1.table.columns({"mesh", "noise", "method", "status", "aep", "rep", "psnr", "ciede2000", "coverage",
                            "seconds", "neighbours", "unanchored_percent", "reprojection_px", "gain_error_percent"}));
  text += "\n![error by method](error_aep.png)\n\n![close-ups by method](closeups.png)\n";
  text += "\n## Table 2: time by stage and size\n\n" + markdown(table2) + "\n![time by size](time_by_size.png)\n";
  text += "\n## Bars\n\n";
  for (const std::string& bar : checkBars(table1.table, table2)) text += "* " + bar + "\n";
  writeText(directory + "/TABLES.md", text);
  return messages;
}

std::vector<std::string> writeAblations(const std::string& directory, const Table& ablations,
                                        const std::string& command) {
  makeDirectory(directory);
  std::vector<std::string> messages;
  writeText(directory + "/ablations.csv", csv(ablations));
  std::string text = "# Ablations\n\n" + describeRun(command) + markdown(ablations);
  std::set<std::string> done;
  for (const auto& row : ablations.rows) {
    const std::string& what = row[0];
    if (!done.insert(what).second) continue;
    const std::string name = "ablation_" + what;
    writeText(directory + "/" + name + ".csv", csv(ablations.where("what", what)));
    tryPlot(directory, name,
            "set style data linespoints\nset xlabel '" + what +
                "' noenhanced\nset ylabel 'AEP'\nset y2label 'REP'\n"
                "set y2tics\nset ytics nomirror\nplot '" +
                name +
                ".csv' using 0:3:xtic(2) every ::1 title 'AEP', '' "
                "using 0:4 every ::1 axes x1y2 title 'REP'",
            messages);
    text += "\n![" + what + "](" + name + ".png)\n";
  }
  writeText(directory + "/ABLATIONS.md", text);
  return messages;
}

}  // namespace cloud_colorizer
