// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Tables of results: CSV for programs and plots, Markdown for people.
#pragma once

#include <string>
#include <vector>

namespace cloud_colorizer {

struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< each as long as the header

  /// Throws std::invalid_argument when the row is not as long as the header.
  void add(const std::vector<std::string>& row);
  /// The columns of the given names, in that order. Throws std::invalid_argument for an unknown name.
  Table columns(const std::vector<std::string>& names) const;
  /// Rows whose column `name` has the value.
  Table where(const std::string& name, const std::string& value) const;
  std::size_t column(const std::string& name) const;
};

std::string csv(const Table& table);
/// Reads what csv() writes. Throws std::runtime_error for a row that is not as long as the header.
Table parseCsv(const std::string& text);
std::string markdown(const Table& table);

/// "3.142" with `digits` decimals; "-" for a number that is not finite.
std::string formatNumber(double value, int digits);

/// Makes the directory and those above it. Throws std::runtime_error when it cannot.
void makeDirectory(const std::string& path);
void writeText(const std::string& path, const std::string& text);

/// Runs `script` by gnuplot inside `directory` (saved as `name`.gp; it makes `name`.png there). False, with the reason
/// in `message`, when gnuplot is missing or fails: the CSV files stand without the plot.
bool plot(const std::string& directory, const std::string& name, const std::string& script, std::string* message);

}  // namespace cloud_colorizer
