// Charts as SVG, drawn by gnuplot.
#pragma once

#include <string>
#include <vector>

namespace pleinair {

struct ChartSeries {
  enum class Style { kLine, kPoints };
  std::string label;
  std::string colour;  // "#rrggbb".
  Style style = Style::kLine;
  std::vector<double> x{};
  std::vector<double> y{};       // NaN leaves a gap.
  std::vector<double> stddev{};  // Empty, or one a point: drawn as a band.
};

struct Chart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<ChartSeries> series;
};

// One <svg> element. Throws std::runtime_error when gnuplot is missing or refuses.
std::string DrawChart(const Chart& chart);

// Points with the spread of both their values, some of them joined to a front.
struct ScatterPoint {
  std::string label;
  double x = 0.0;
  double x_smallest = 0.0;
  double x_largest = 0.0;
  double y = 0.0;
  double y_smallest = 0.0;
  double y_largest = 0.0;
  bool on_front = false;
  bool is_marked = false;
};

struct ScatterChart {
  std::string x_label;  // Its axis is logarithmic: all x above 0.
  std::string y_label;
  std::vector<ScatterPoint> points;  // At least one.
};

std::string DrawScatter(const ScatterChart& chart);

}  // namespace pleinair
