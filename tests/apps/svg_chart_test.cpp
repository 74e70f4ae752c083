// Charts, as gnuplot draws them.
#include "apps/svg_chart.h"

#include <cmath>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/scratch_folder.h"

namespace pleinair::svg_chart_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

Chart Between(double low, double high) {
  ChartSeries series{"a series", "#2060c0"};
  series.points = {{ChartValue::Exact(1.0), {low, low, low}, ""},
                   {ChartValue::Exact(2.0), {high, 0.9 * high, 1.1 * high}, "the end"}};
  return {"A title", {"time, ms"}, {"error, %"}, {series}};
}

TEST(SvgChart, NamesItsAxesSeriesAndPoints) {
  const std::string svg = DrawChart(Between(1.0, 2.0));
  EXPECT_THAT(svg,
              AllOf(testing::StartsWith("<svg"),
                    HasSubstr("A title"),
                    HasSubstr("time, ms"),
                    HasSubstr("error, %"),
                    HasSubstr("a series"),
                    HasSubstr("the end")));
}

bool HasMark(const std::string& svg, const std::string& text) {
  return svg.find("<text>" + text + "</text>") != std::string::npos;
}

// What is far apart is on a logarithmic scale, what is not has a scale around its values.
TEST(SvgChart, ScalesShowDifferences) {
  const std::string wide = DrawChart(Between(0.1, 40.0));
  EXPECT_TRUE(HasMark(wide, "0.1") && HasMark(wide, "1") && HasMark(wide, "10"));
  const std::string narrow = DrawChart(Between(10.0, 10.4));
  EXPECT_TRUE(HasMark(narrow, "10.5"));
  EXPECT_FALSE(HasMark(narrow, "0") || HasMark(narrow, "5"));
  Chart from_zero = Between(10.0, 10.4);
  from_zero.y.scale = ChartAxis::Scale::kFromZero;
  EXPECT_TRUE(HasMark(DrawChart(from_zero), "0"));
}

TEST(SvgChart, LogarithmicMarksAreRoundAndEnough) {
  EXPECT_THAT(LogarithmicMarks(0.5, 2000.0), ElementsAre(1.0, 10.0, 100.0, 1000.0));
  EXPECT_THAT(LogarithmicMarks(0.9, 21.0), ElementsAre(1.0, 2.0, 5.0, 10.0, 20.0));
  for (const double ratio : {4.0, 7.0, 30.0, 1e5}) {
    for (double low = 1e-3; low < 10.0; low *= 1.37) {
      EXPECT_GE(LogarithmicMarks(low, ratio * low).size(), 4u) << low << " times " << ratio;
      EXPECT_LE(LogarithmicMarks(low, ratio * low).size(), 9u) << low << " times " << ratio;
    }
  }
}

TEST(SvgChart, CategoriesStandFromTheTop) {
  Chart chart = Between(1.0, 2.0);
  chart.y.categories = {"upper", "lower"};
  const std::string svg = DrawChart(chart);
  EXPECT_THAT(svg, AllOf(HasSubstr("upper"), HasSubstr("lower")));
}

TEST(SvgChart, ChartsStandUnderOneAnother) {
  const std::vector<Chart> charts{Between(1.0, 2.0), Between(3.0, 300.0)};
  const std::string svg = DrawCharts(charts);
  EXPECT_THAT(svg, HasSubstr("height=\"660\""));
}

// Names come from users' files.
TEST(SvgChart, NoTextIsRunOrRead) {
  const ScratchFolder scratch;
  const std::string mark = (scratch.Path() / "mark").string();
  Chart chart = Between(1.0, 2.0);
  const std::string hostile = "`touch " + mark + "` '; system(\"touch " + mark + "\") \" $(x) a_b";
  chart.title = hostile;
  chart.x.label = hostile;
  chart.y.categories = {hostile, "b"};
  chart.series[0].label = hostile;
  chart.series[0].points[0].label = hostile;
  EXPECT_THAT(DrawChart(chart), HasSubstr("a_b"));
  EXPECT_FALSE(std::filesystem::exists(mark));
}

TEST(SvgChart, RefusesToDrawNothing) {
  EXPECT_THROW(DrawCharts({}), std::runtime_error);
  Chart chart = Between(1.0, 2.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  chart.series[0].points = {{ChartValue::Exact(nan), ChartValue::Exact(nan), ""}};
  EXPECT_THROW(DrawChart(chart), std::runtime_error);
}

}  // namespace
}  // namespace pleinair::svg_chart_test
