// Line charts as SVG, drawn by gnuplot.
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

}  // namespace pleinair
