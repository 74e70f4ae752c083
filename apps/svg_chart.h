// Charts as SVG, drawn by gnuplot; narrow enough to be read on a phone.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace pleinair {

// A value and how far it may be off. If all three are equal, no bar is drawn.
struct ChartValue {
  double value = 0.0;  // NaN leaves a gap in a line.
  double low = 0.0;
  double high = 0.0;

  static ChartValue Exact(double value) { return {value, value, value}; }
};

struct ChartPoint {
  ChartValue x;
  ChartValue y;
  std::string label;  // Beside the point; empty: none.
};

struct ChartSeries {
  enum class Style {
    kLine,    // Joined points, with bars.
    kBand,    // The same, with a band in place of bars.
    kDashes,  // A dashed line without points or bars.
    kPoints,  // Points with bars.
    kStairs,  // As a Pareto front is joined: what lies right of a step is as low as it.
  };
  std::string label;   // For the key; empty: not in it.
  std::string colour;  // "#rrggbb".
  Style style = Style::kLine;
  std::vector<ChartPoint> points{};  // kStairs: by ascending x.
  double point_size = 1.0;
};

struct ChartAxis {
  enum class Scale {
    kFromZero,
    kByValues,  // Logarithmic where values are positive and far apart; else linear, around them.
  };
  std::string label;  // With the unit.
  Scale scale = Scale::kByValues;
  // Names for 1, 2, ...; from the top where it is the upright axis. Empty: an axis of numbers.
  std::vector<std::string> categories{};
};

struct Chart {
  std::string title;  // Empty: none.
  ChartAxis x;
  ChartAxis y;
  std::vector<ChartSeries> series;  // At least one point in all.
};

// One <svg> element with the charts under one another. Texts are shown as they are.
// Throws std::runtime_error when gnuplot is missing or refuses, or there is nothing to draw.
std::string DrawCharts(std::span<const Chart> charts);
std::string DrawChart(const Chart& chart);

// The same for an HTML page: where they cannot be drawn, a paragraph with the reason, which is
// logged, too. Figures that took hours to measure are in tables as well, and not lost with a
// picture.
std::string ChartsForPage(std::span<const Chart> charts);

// Where an axis from `low` to `high` (both above 0) has its marks when it is logarithmic: round
// numbers, at least three of them within it, or as many as two digits give.
std::vector<double> LogarithmicMarks(double low, double high);

}  // namespace pleinair
