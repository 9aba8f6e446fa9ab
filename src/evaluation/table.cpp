// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/table.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/file_io.hpp"
#include "base/text.hpp"
#include "cloud_colorizer/base/check.hpp"

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

}  // namespace

void ResultTable::add(const std::vector<std::string>& row) {
  require<std::invalid_argument>(row.size() == header.size(), "row of ", row.size(), " cells in a table of ",
                                 header.size(), " columns");
  rows.push_back(row);
}

std::size_t ResultTable::column(const std::string& name) const {
  const auto found = std::find(header.begin(), header.end(), name);
  require<std::invalid_argument>(found != header.end(), "the table has no column '", name, "'");
  return static_cast<std::size_t>(found - header.begin());
}

std::string csv(const ResultTable& table) {
  std::string text = joined(table.header, "", ",", "");
  for (std::vector<std::string> row : table.rows) {
    for (std::string& cell : row) cell = csvCell(cell);
    text += joined(row, "", ",", "");
  }
  return text;
}

std::string markdown(const ResultTable& table) {
  std::string text = joined(table.header, "| ", " | ", " |");
  text += joined(std::vector<std::string>(table.header.size(), "---"), "|", "|", "|");
  for (const auto& row : table.rows) text += joined(row, "| ", " | ", " |");
  return text;
}

std::string formatNumber(double value, int digits) {
  return std::isfinite(value) ? formatFixed(value, digits) : "-";
}

void makeDirectory(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  require(!error && std::filesystem::is_directory(path), "cannot make the directory ", path, ": ", error.message());
}

void writeText(const std::string& path, const std::string& text) {
  writeFileAtomically(path, text.data(), text.size());
}

}  // namespace cloud_colorizer
