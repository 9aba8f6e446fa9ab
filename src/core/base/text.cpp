// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <locale>
#include <sstream>

namespace cloud_colorizer {

namespace {

locale_t plainLocale() {
  static const locale_t locale = newlocale(LC_ALL_MASK, "C", nullptr);
  return locale;
}

}  // namespace

std::string formatDouble(double value) {
  std::string text;
  for (const int digits : {15, 16, 17}) {
    std::ostringstream stream;
    stream.imbue(std::locale::classic());
    stream << std::setprecision(digits) << value;
    text = stream.str();
    double read = 0;
    if (parseDouble(text, read) && read == value) break;
  }
  return text;
}

std::string formatFixed(double value, int decimals) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream << std::fixed << std::setprecision(decimals) << value;
  return stream.str();
}

std::string sixDigits(std::size_t number) {
  char text[32];
  std::snprintf(text, sizeof text, "%06zu", number);
  return text;
}

bool parseDouble(const char*& text, double& value) {
  char* end = nullptr;
  value = strtod_l(text, &end, plainLocale());
  if (end == text) return false;
  if (*end == '#') {  // Microsoft's -1.#IND, 1.#QNAN, 1.#INF
    const bool is_infinite = std::strncmp(end, "#INF", 4) == 0;
    if (!is_infinite && std::strncmp(end, "#IND", 4) != 0 && std::strncmp(end, "#QNAN", 5) != 0) return false;
    value = is_infinite ? std::copysign(HUGE_VAL, value) : std::nan("");
    while (*end != '\0' && std::isspace(static_cast<unsigned char>(*end)) == 0) ++end;
  }
  text = end;
  return true;
}

bool parseDouble(const std::string& word, double& value) {
  const char* text = word.c_str();
  return parseDouble(text, value) && text == word.c_str() + word.size();
}

bool parseInteger(const std::string& word, long long& value) {
  char* end = nullptr;
  errno = 0;
  value = std::strtoll(word.c_str(), &end, 10);
  return errno == 0 && !word.empty() && end == word.c_str() + word.size();
}

std::vector<std::string> splitWords(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::vector<std::string> splitAt(const std::string& line, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : line) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words) text += (&word == words.data() ? "" : separator) + word;
  return text;
}

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string lowerExtension(const std::string& path) {
  return lowerCase(std::filesystem::path(path).extension().string());
}

}  // namespace cloud_colorizer
