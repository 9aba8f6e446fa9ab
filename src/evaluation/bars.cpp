// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The bars that the tables must meet, one sentence each with its numbers.
#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "cloud_colorizer/evaluation/tables.hpp"

namespace cloud_colorizer {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A cell as a number; NaN for "-".
double number(const Table& table, std::size_t row, const std::string& column) {
  const std::string& cell = table.rows[row][table.column(column)];
  return cell.empty() || cell == "-" ? kNan : std::atof(cell.c_str());
}

std::string sentence(bool met, const std::string& text) {
  return (met ? "met: " : "MISSED: ") + text;
}

/// Scores of the methods of one mesh and kind of noise.
struct Group {
  std::string name;
  std::map<std::string, double> aep, seconds;
};

std::vector<Group> groupsOf(const Table& table1) {
  std::vector<Group> groups;
  for (std::size_t r = 0; r < table1.rows.size(); ++r) {
    const std::string name = table1.rows[r][table1.column("mesh")] + ", " + table1.rows[r][table1.column("noise")];
    if (groups.empty() || groups.back().name != name) groups.push_back({name, {}, {}});
    const std::string& method = table1.rows[r][table1.column("method")];
    groups.back().aep[method] = number(table1, r, "aep");
    groups.back().seconds[method] = number(table1, r, "seconds");
  }
  return groups;
}

std::string fourPassBar(const Group& g) {
  const double aep = g.aep.at("4-pass"), other = g.aep.at("20-NN");
  const double ratio = g.seconds.at("20-NN") / g.seconds.at("4-pass");
  const bool stopped = other != other;  // then only the time can be compared
  return sentence((stopped || aep <= 1.05 * other) && ratio > 3,
                  g.name + ": 4-pass AEP " + formatNumber(aep, 2) + ", 20-NN " + formatNumber(other, 2) +
                      (stopped ? " (stopped at the limit)" : "") + "; 20-NN takes " + formatNumber(ratio, 1) +
                      " times as long");
}

std::string defaultBar(const Group& g) {
  std::string best_name;
  double best = std::numeric_limits<double>::infinity();
  for (const auto& [method, aep] : g.aep) {
    if (method == "default" || !(aep < best)) continue;
    best = aep;
    best_name = method;
  }
  const double aep = g.aep.at("default");
  return sentence(aep <= 1.02 * best, g.name + ": default AEP " + formatNumber(aep, 2) + ", best other row " +
                                          best_name + " " + formatNumber(best, 2));
}

/// The paper's failure: where the points are no uniform samples, 5-NN has parts without an anchor.
std::vector<std::string> isolatedBars(const Table& isolated) {
  std::vector<std::string> sentences;
  if (isolated.rows.empty()) return sentences;
  const Table nearest = isolated.where("graph", "5-NN");
  for (std::size_t r = 0; r < nearest.rows.size(); ++r) {
    const std::string& sampling = nearest.rows[r][nearest.column("sampling")];
    if (sampling == kUniformSampling) continue;
    const double share = number(nearest, r, "unanchored_percent"), plain = number(nearest, r, "plain_aep"),
                 anchored = number(nearest, r, "aep");
    sentences.push_back(sentence(share > 0 && plain > anchored, sampling + ": 5-NN leaves " + formatNumber(share, 3) +
                                                                    " % of the points without an anchor: AEP " +
                                                                    formatNumber(plain, 2) + ", with our rule " +
                                                                    formatNumber(anchored, 2)));
  }
  return sentences;
}

/// Four passes against the 20 nearest neighbours at other numbers of points.
std::vector<std::string> densityBars(const Table& density) {
  std::vector<std::string> sentences;
  for (std::size_t r = 0; r < density.rows.size(); ++r) {
    const double ours = number(density, r, "4-pass"), other = number(density, r, "20-NN");
    if (other != other) continue;  // it ran into the limit
    sentences.push_back(sentence(ours <= 1.05 * other, density.rows[r][density.column("mesh")] + ", intensities, " +
                                                           density.rows[r][density.column("points")] +
                                                           " points: 4-pass AEP " + formatNumber(ours, 2) + ", 20-NN " +
                                                           formatNumber(other, 2)));
  }
  return sentences;
}

std::optional<double> totalSeconds(const Table& table2, const std::string& graph, const std::string& solver,
                                   const std::string& points) {
  for (std::size_t r = 0; r < table2.rows.size(); ++r) {
    const auto& row = table2.rows[r];
    if (row[table2.column("graph")] != graph || row[table2.column("solver")] != solver) continue;
    if (row[table2.column("points")] != points || row[table2.column("status")] != "ok") continue;
    return number(table2, r, "total_s");
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::string> checkBars(const Tables& tables) {
  std::vector<std::string> sentences;
  for (const Group& group : groupsOf(tables.table1.table)) {
    sentences.push_back(fourPassBar(group));
    sentences.push_back(defaultBar(group));
  }
  for (const std::string& bar : densityBars(tables.density)) sentences.push_back(bar);
  for (const std::string& bar : isolatedBars(tables.isolated)) sentences.push_back(bar);
  const Table& table2 = tables.table2;
  std::set<long> sizes;
  for (const auto& row : table2.rows) sizes.insert(std::atol(row[table2.column("points")].c_str()));
  for (const long size : sizes) {
    const std::string points = std::to_string(size);
    const auto ours = totalSeconds(table2, "4-pass", "CHOLMOD", points);
    if (!ours) continue;
    const auto nearest = totalSeconds(table2, "20-NN", "SuiteSparseQR", points);
    const auto qr = totalSeconds(table2, "4-pass", "SuiteSparseQR", points);
    const auto against = [&](const std::string& what, const std::optional<double>& seconds, double factor) {
      const bool met = !seconds || *seconds >= factor * *ours;
      sentences.push_back(sentence(
          met, points + " points: 4-pass with CHOLMOD " + formatNumber(*ours, 2) + " s; " + what + " " +
                   (seconds ? formatNumber(*seconds, 2) + " s, " + formatNumber(*seconds / *ours, 1) + " times as long"
                            : std::string("was stopped at the limit")) +
                   " (at least " + formatNumber(factor, 0) + " asked for)"));
    };
    against("20-NN with SuiteSparseQR", nearest, 20);
    against("4-pass with SuiteSparseQR", qr, 3);
  }
  return sentences;
}

}  // namespace cloud_colorizer
