// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Tables of results: CSV for programs, Markdown for people. scripts/report.py makes plots and reports of the CSV
/// files.
#pragma once

#include <string>
#include <vector>

namespace cloud_colorizer {

struct ResultTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< each as long as the header

  /// Throws std::invalid_argument when the row is not as long as the header.
  void add(const std::vector<std::string>& row);
  /// Throws std::invalid_argument for an unknown name.
  std::size_t column(const std::string& name) const;
};

std::string csv(const ResultTable& table);
std::string markdown(const ResultTable& table);

/// "3.142" with `digits` decimals; "-" for a number that is not finite.
std::string formatNumber(double value, int digits);

/// Makes the directory and those above it. Throws std::runtime_error when it cannot.
void makeDirectory(const std::string& path);
void writeText(const std::string& path, const std::string& text);

}  // namespace cloud_colorizer
