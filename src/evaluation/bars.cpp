// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The bars that the tables must meet, one sentence each with its numbers.
#include <algorithm>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "evaluation/tables.hpp"

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

/// Rows of Table 2 by graph, solver and number of points.
class Speed {
 public:
  explicit Speed(const Table& table2) : table_(table2) {}

  std::set<long> sizes() const {
    std::set<long> sizes;
    for (const auto& row : table_.rows) sizes.insert(std::atol(row[table_.column("points")].c_str()));
    return sizes;
  }

  /// Four passes against the slower ways, of as many points.
  std::vector<std::string> bars(long points, const std::string& graph, const std::string& solver) const {
    std::vector<std::string> sentences;
    const auto ours = totalSeconds(points, graph, solver);
    if (!ours) return sentences;
    const auto against = [&](const std::string& other, double factor) {
      const auto seconds = totalSeconds(points, other, "SuiteSparseQR");
      sentences.push_back(sentence(
          !seconds || *seconds >= factor * *ours,
          std::to_string(points) + " points: " + graph + " with " + solver + " " + formatNumber(*ours, 2) + " s; " +
              other + " with SuiteSparseQR " +
              (seconds ? formatNumber(*seconds, 2) + " s, " + formatNumber(*seconds / *ours, 1) + " times as long"
                       : std::string("was stopped at the limit")) +
              " (at least " + formatNumber(factor, 0) + " asked for)"));
    };
    against("20-NN", 20);
    against(graph, 3);
    return sentences;
  }

 private:
  std::optional<double> totalSeconds(long points, const std::string& graph, const std::string& solver) const {
    for (std::size_t r = 0; r < table_.rows.size(); ++r) {
      const auto& row = table_.rows[r];
      if (row[table_.column("graph")] != graph || row[table_.column("solver")] != solver) continue;
      if (row[table_.column("points")] != std::to_string(points) || row[table_.column("status")] != "ok") continue;
      return number(table_, r, "total_s");
    }
    return std::nullopt;
  }

  const Table& table_;
};

}  // namespace

std::vector<std::string> checkBars(const Tables& tables) {
  std::vector<std::string> sentences;
  for (const Group& group : groupsOf(tables.table1.table)) {
    sentences.push_back(fourPassBar(group));
    sentences.push_back(defaultBar(group));
  }
  for (const std::string& bar : densityBars(tables.density)) sentences.push_back(bar);
  for (const std::string& bar : isolatedBars(tables.isolated)) sentences.push_back(bar);
  const Speed speed(tables.table2);
  for (const long points : speed.sizes()) {
    for (const std::string& bar : speed.bars(points, "4-pass", "CG")) sentences.push_back(bar);
    for (const std::string& bar : speed.bars(points, "4-pass shared", "CHOLMOD")) sentences.push_back(bar);
  }
  return sentences;
}

}  // namespace cloud_colorizer
