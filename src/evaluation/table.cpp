// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/table.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "cloud_colorizer/base/check.hpp"
#include "cloud_colorizer/cloud/cloud_io.hpp"

namespace cloud_colorizer {
namespace {

std::string joined(const std::vector<std::string>& cells, const std::string& begin, const std::string& between,
                   const std::string& end) {
  std::string line = begin;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i == 0 ? "" : between) + cells[i];
  return line + end + "\n";
}

std::string csvCell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// The cells of the line that begins at `at`, which comes to stand at the next one.
std::vector<std::string> parseLine(const std::string& text, std::size_t& at) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '"' && quoted && at + 1 < text.size() && text[at + 1] == '"') {
      cells.back() += text[++at];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else if (c == '\n' && !quoted) {
      ++at;
      break;
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

}  // namespace

void Table::add(const std::vector<std::string>& row) {
  require<std::invalid_argument>(row.size() == header.size(), "row of ", row.size(), " cells in a table of ",
                                 header.size(), " columns");
  rows.push_back(row);
}

std::size_t Table::column(const std::string& name) const {
  const auto found = std::find(header.begin(), header.end(), name);
  require<std::invalid_argument>(found != header.end(), "the table has no column '", name, "'");
  return static_cast<std::size_t>(found - header.begin());
}

Table Table::columns(const std::vector<std::string>& names) const {
  Table chosen{names, {}};
  for (const auto& row : rows) {
    std::vector<std::string> cells;
    for (const std::string& name : names) cells.push_back(row[column(name)]);
    chosen.add(cells);
  }
  return chosen;
}

Table Table::where(const std::string& name, const std::string& value) const {
  Table chosen{header, {}};
  const std::size_t index = column(name);
  for (const auto& row : rows) {
    if (row[index] == value) chosen.add(row);
  }
  return chosen;
}

std::string csv(const Table& table) {
  std::string text = joined(table.header, "", ",", "");
  for (std::vector<std::string> row : table.rows) {
    for (std::string& cell : row) cell = csvCell(cell);
    text += joined(row, "", ",", "");
  }
  return text;
}

Table parseCsv(const std::string& text) {
  std::size_t at = 0;
  Table table{parseLine(text, at), {}};
  while (at < text.size()) {
    const std::vector<std::string> row = parseLine(text, at);
    require(row.size() == table.header.size(), "row ", table.rows.size() + 1, " of a CSV file has ", row.size(),
            " cells under a header of ", table.header.size());
    table.rows.push_back(row);
  }
  return table;
}

std::string markdown(const Table& table) {
  std::string text = joined(table.header, "| ", " | ", " |");
  text += joined(std::vector<std::string>(table.header.size(), "---"), "|", "|", "|");
  for (const auto& row : table.rows) text += joined(row, "| ", " | ", " |");
  return text;
}

std::string formatNumber(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

void makeDirectory(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  require(!error && std::filesystem::is_directory(path), "cannot make the directory ", path, ": ", error.message());
}

void writeText(const std::string& path, const std::string& text) {
  writeFileAtomically(path, text.data(), text.size());
}

bool plot(const std::string& directory, const std::string& name, const std::string& script, std::string* message) {
  const std::string file = name + ".gp";
  writeText(directory + "/" + file, "set terminal pngcairo size 1100,700 font 'sans,12'\nset output '" + name +
                                        ".png'\nset datafile separator ','\nset grid\nset style line 1 lw 2\n" +
                                        script + "\n");
  const pid_t child = fork();
  require(child >= 0, "cannot start a process for gnuplot");
  if (child == 0) {
    if (chdir(directory.c_str()) != 0) _exit(126);
    execlp("gnuplot", "gnuplot", file.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code == 127) *message = "gnuplot is not installed (Debian: gnuplot-nox); " + name + " has its CSV only";
  if (code != 127 && code != 0) *message = "gnuplot failed on " + directory + "/" + file;
  return code == 0;
}

}  // namespace cloud_colorizer
