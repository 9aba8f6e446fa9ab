// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// Numbers and words as text, whatever the locale of the process.
#pragma once

#include <string>
#include <vector>

namespace cloud_colorizer {

/// The shortest text that reads back as the same double.
std::string formatDouble(double value);
std::string formatFixed(double value, int decimals);
std::string sixDigits(std::size_t number);  ///< with leading zeros, at least

/// Reads one number at `text` and moves `text` behind it; false, without moving, when there is none.
bool parseDouble(const char*& text, double& value);
/// The whole word as a number; false when it is none.
bool parseDouble(const std::string& word, double& value);
bool parseInteger(const std::string& word, long long& value);

std::vector<std::string> splitWords(const std::string& line);  ///< at white space
std::vector<std::string> splitAt(const std::string& line, char separator);
std::string join(const std::vector<std::string>& words, const std::string& separator);

bool endsWith(const std::string& text, const std::string& end);

std::string lowerCase(std::string text);

/// Of a path, in lower case, with its dot.
std::string lowerExtension(const std::string& path);

}  // namespace cloud_colorizer
