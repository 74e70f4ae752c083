#include "apps/svg_chart.h"

#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ostream.h>

namespace pleinair {
namespace {

// A folder of its own that goes with the scope.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "pleinair-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw std::runtime_error(name + ": no scratch folder can be made there");
    }
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& Path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string ReadAll(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void WriteData(const ChartSeries& series, std::ofstream& out) {
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!std::isfinite(series.y[i])) {
      fmt::print(out, "\n");  // gnuplot breaks the line at an empty one.
      continue;
    }
    const double stddev = series.stddev.empty() ? 0.0 : series.stddev[i];
    fmt::print(
        out, "{} {} {} {}\n", series.x[i], series.y[i], series.y[i] - stddev, series.y[i] + stddev);
  }
}

// The <svg> that `script` makes of `picture`.
std::string RunGnuplot(const std::filesystem::path& script,
                       const std::filesystem::path& picture,
                       const std::string& title) {
  const std::string command = fmt::format("gnuplot '{0}' > '{0}.log' 2>&1", script.string());
  if (std::system(command.c_str()) != 0) {
    const std::string log = ReadAll(script.string() + ".log");
    throw std::runtime_error(
        "gnuplot could not draw \"" + title +
        "\" (is the package gnuplot-nox installed?): " + log.substr(0, log.find('\n')));
  }
  const std::string svg = ReadAll(picture);
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string::npos) {
    throw std::runtime_error("gnuplot drew nothing for \"" + title + "\"");
  }
  return svg.substr(begin);
}

}  // namespace

std::string DrawChart(const Chart& chart) {
  const ScratchFolder scratch;
  const std::filesystem::path script = scratch.Path() / "chart.gp";
  const std::filesystem::path picture = scratch.Path() / "chart.svg";
  {
    std::ofstream out(script);
    fmt::print(out, "set terminal svg size 900,300 font 'sans,11' background '#ffffff'\n");
    fmt::print(out, "set output '{}'\n", picture.string());
    fmt::print(out, "set title \"{}\"\nset xlabel \"{}\"\n", chart.title, chart.x_label);
    fmt::print(out, "set ylabel \"{}\"\n", chart.y_label);
    fmt::print(out, "set grid\nset key outside right top\nset border 3\nset tics nomirror\n");
    fmt::print(
        out,
        "set yrange [0:*]\nset xrange [*:*] noextend\nset offsets graph 0.02, graph 0.02, 0, 0\n");
    std::string plots;
    for (std::size_t i = 0; i < chart.series.size(); ++i) {
      const ChartSeries& series = chart.series[i];
      const std::string data = fmt::format("{}/{}.dat", scratch.Path().string(), i);
      std::ofstream data_out(data);
      WriteData(series, data_out);
      if (!series.stddev.empty()) {
        plots += fmt::format(
            "{}'{}' using 1:3:4 with filledcurves fillcolor rgb '{}' fillstyle transparent solid "
            "0.2 "
            "noborder notitle",
            plots.empty() ? "" : ", ",
            data,
            series.colour);
      }
      plots += fmt::format("{}'{}' using 1:2 with {} linecolor rgb '{}' title \"{}\"",
                           plots.empty() ? "" : ", ",
                           data,
                           series.style == ChartSeries::Style::kLine
                               ? "linespoints linewidth 2 pointtype 7 pointsize 0.3"
                               : "points pointtype 6 pointsize 0.8",
                           series.colour,
                           series.label);
    }
    fmt::print(out, "plot {}\n", plots);
  }
  return RunGnuplot(script, picture, chart.title);
}

// Front points joined as the stairs that no setting gets below; labels over their points.
std::string DrawScatter(const ScatterChart& chart) {
  const ScratchFolder scratch;
  const std::filesystem::path script = scratch.Path() / "chart.gp";
  const std::filesystem::path picture = scratch.Path() / "chart.svg";
  std::vector<ScatterPoint> front;
  double least_x = std::numeric_limits<double>::infinity();
  double most_x = 0.0;
  std::string all;
  std::string marked;
  for (const ScatterPoint& point : chart.points) {
    const std::string line = fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} \"{}\"\n",
                                         point.x,
                                         point.y,
                                         point.x_smallest,
                                         point.x_largest,
                                         point.y_smallest,
                                         point.y_largest,
                                         point.label);
    (point.is_marked ? marked : all) += line;
    least_x = std::min(least_x, point.x_smallest);
    most_x = std::max(most_x, 1.1 * point.x_largest);
    if (point.on_front) front.push_back(point);
  }
  std::sort(front.begin(), front.end(), [](const ScatterPoint& a, const ScatterPoint& b) {
    return a.x < b.x;
  });
  {
    std::ofstream out(script);
    fmt::print(out, "set terminal svg size 760,300 font 'sans,11' noenhanced\n");
    fmt::print(out, "set output '{}'\n", picture.string());
    fmt::print(out, "set xlabel \"{}\"\nset ylabel \"{}\"\n", chart.x_label, chart.y_label);
    fmt::print(out, "set border 3\nset tics nomirror\nset logscale x\nset yrange [0:*]\n");
    fmt::print(out, "set offsets 0, 0, graph 0.08, 0\nset key off\n");
    // Room for the labels on the right.
    fmt::print(out,
               "set xrange [{:.6g}:{:.6g}]\n",
               0.9 * least_x,
               most_x * std::pow(most_x / least_x, 0.15));
    fmt::print(out, "$front << E\n");
    for (const ScatterPoint& point : front) fmt::print(out, "{:.6g} {:.6g}\n", point.x, point.y);
    fmt::print(out, "E\n$all << E\n{}E\n$marked << E\n{}E\n", all, marked);
    std::string plots;
    const auto add = [&](const std::string& plot) { plots += (plots.empty() ? "" : ", ") + plot; };
    if (!front.empty()) add("$front with steps linewidth 1.5 linecolor rgb '#2060c0'");
    const auto add_points = [&](const char* data, const char* colour, const char* style) {
      add(fmt::format(
          "{} using 1:2:3:4:5:6 with xyerrorbars pointtype 7 pointsize {} linecolor rgb "
          "'{}'",
          data,
          style,
          colour));
      add(fmt::format(
          "{} using 1:2:7 with labels left offset 0.6,0.6 textcolor rgb '{}'", data, colour));
    };
    if (!all.empty()) add_points("$all", "#606060", "0.4");
    if (!front.empty()) add("$front with points pointtype 7 pointsize 0.6 linecolor rgb '#2060c0'");
    if (!marked.empty()) add_points("$marked", "#c03000", "0.7");
    fmt::print(out, "plot {}\n", plots);
  }
  return RunGnuplot(script, picture, chart.y_label);
}

}  // namespace pleinair
