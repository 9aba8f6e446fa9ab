// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/param_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <locale>

#include "base/robust.hpp"
#include "cloud_colorizer/map/params.hpp"

namespace cloud_colorizer {
namespace {

/// A locale that writes 1.5 as "1,5" and a thousand as "1.000".
struct CommaNumbers : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

class InLocale {
 public:
  explicit InLocale(const std::locale& locale) : before_(std::locale::global(locale)) {}
  ~InLocale() { std::locale::global(before_); }

 private:
  std::locale before_;
};

TEST(ParamText, NumbersDoNotDependOnTheLocale) {
  const InLocale comma(std::locale(std::locale::classic(), new CommaNumbers));
  EXPECT_EQ(parseValue<double>("x", "0.125"), 0.125);
  EXPECT_EQ(formatValue(12345.5), "12345.5");
  EXPECT_EQ(formatValue(1234567), "1234567");
  Params params;
  setParam(params, "voxel_size", "0.25");
  EXPECT_EQ(params.record.voxel_size, 0.25);
  for (const ParamText& param : describeParams(params)) {
    EXPECT_EQ(param.value.find(','), std::string::npos) << param.name << " = " << param.value;
  }
}

TEST(ParamText, InfinityIsANumber) {
  EXPECT_EQ(parseValue<double>("x", "inf"), INFINITY);
  EXPECT_EQ(parseValue<double>("x", formatValue(-INFINITY)), -INFINITY);
}

TEST(ParamText, EveryDoubleSurvives) {
  for (const double value : {0.1, 1.0 / 3, 1e-300, 123456789.123456789, -0.0}) {
    EXPECT_EQ(parseValue<double>("x", formatValue(value)), value);
  }
}

TEST(ParamText, TypesAreKeptApart) {
  EXPECT_EQ(parseValue<int>("n", "1e3"), 1000);
  EXPECT_THROW(parseValue<int>("n", "1.5"), std::invalid_argument);
  EXPECT_THROW(parseValue<int>("n", "1e10"), std::invalid_argument);
  EXPECT_THROW(parseValue<int>("n", "nan"), std::invalid_argument);
  EXPECT_THROW(parseValue<std::size_t>("n", "-1"), std::invalid_argument);
  EXPECT_THROW(parseValue<double>("x", " 1"), std::invalid_argument);
  EXPECT_THROW(parseValue<double>("x", "1 "), std::invalid_argument);
  EXPECT_THROW(parseValue<bool>("b", "yes"), std::invalid_argument);
  EXPECT_TRUE(parseValue<bool>("b", "1"));
  EXPECT_EQ(parseValue<Method>("m", "paper"), Method::kPaper);
}

TEST(ParamText, ListsAreSplitAtTheSeparator) {
  EXPECT_EQ(parseList<int>("size", "960x540", 'x'), (std::vector<int>{960, 540}));
  EXPECT_THROW(parseList<double>("eye", "1,,2", ','), std::invalid_argument);
  EXPECT_EQ(join({"a", "", "b"}, "; "), "a; ; b");
}

TEST(Robust, MedianAndSigma) {
  EXPECT_EQ(median(std::vector<float>{}), 0);
  EXPECT_EQ(median(std::vector<double>{3, 1, 2}), 2);
  EXPECT_EQ(robustSigma({0, 1, 100}, 0.5F), 1.4826F);
  EXPECT_EQ(robustSigma({0, 0, 100}, 0.5F), 0.5F);
  EXPECT_EQ(cauchyWeight(0, 1), 1);
}

}  // namespace
}  // namespace cloud_colorizer
