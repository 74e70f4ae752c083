#include "apps/svg_chart.h"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace pleinair {
namespace {

// A file in memory that goes with the scope: gnuplot needs no folder that can be written.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content = {})
      : file_(memfd_create("pleinair-chart", MFD_CLOEXEC)) {
    if (file_ < 0) throw std::runtime_error("no memory for a chart: " + LastError());
    while (!content.empty()) {
      const ssize_t written = write(file_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) throw std::runtime_error("no memory for a chart: " + LastError());
      content.remove_prefix(static_cast<std::size_t>(written));
    }
    lseek(file_, 0, SEEK_SET);
  }
  ~MemoryFile() { close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int Descriptor() const { return file_; }
  std::string Content() const {
    std::string content;
    std::array<char, 4096> buffer{};
    lseek(file_, 0, SEEK_SET);
    for (ssize_t count = 0; (count = read(file_, buffer.data(), buffer.size())) > 0;) {
      content.append(buffer.data(), static_cast<std::size_t>(count));
    }
    return content;
  }

 private:
  static std::string LastError() { return std::generic_category().message(errno); }

  int file_;
};

// gnuplot's rows of a series; an empty line breaks the curve.
std::string DataOf(const ChartSeries& series) {
  std::string rows;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double stddev = series.stddev.empty() ? 0.0 : series.stddev[i];
    rows += std::isfinite(series.y[i]) ? fmt::format("{} {} {} {}\n",
                                                     series.x[i],
                                                     series.y[i],
                                                     series.y[i] - stddev,
                                                     series.y[i] + stddev)
                                       : std::string("\n");
  }
  return rows;
}

// gnuplot quotes the command first, and says at the end what is wrong with it.
std::string LastLineOf(std::string text) {
  text.erase(text.find_last_not_of(" \n") + 1);
  return text.substr(text.rfind('\n') + 1);
}

// The <svg> that gnuplot makes of `script`, without a shell or a file.
std::string RunGnuplot(const std::string& script, const std::string& title) {
  const MemoryFile input(script);
  const MemoryFile output;
  const MemoryFile log;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.Descriptor(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output.Descriptor(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, log.Descriptor(), STDERR_FILENO);
  std::string program = "gnuplot";
  std::string from_standard_input = "-";
  const std::array<char*, 3> arguments{program.data(), from_standard_input.data(), nullptr};
  pid_t child = 0;
  const int failure =
      posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  const std::string cannot = "gnuplot could not draw \"" + title + "\": ";
  if (failure != 0) {
    throw std::runtime_error(cannot + std::generic_category().message(failure) +
                             " (is the package gnuplot-nox installed?)");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const std::string svg = output.Content();
  const std::size_t begin = svg.find("<svg");
  if (status != 0 || begin == std::string::npos) {
    throw std::runtime_error(cannot + LastLineOf(log.Content()));
  }
  return svg.substr(begin);
}

}  // namespace

std::string DrawChart(const Chart& chart) {
  std::string script =
      "set terminal svg size 900,300 font 'sans,11' background '#ffffff'\n"
      "set grid\nset key outside right top\nset border 3\nset tics nomirror\n"
      "set yrange [0:*]\nset xrange [*:*] noextend\nset offsets graph 0.02, graph 0.02, 0, 0\n";
  script += fmt::format("set title \"{}\"\nset xlabel \"{}\"\nset ylabel \"{}\"\n",
                        chart.title,
                        chart.x_label,
                        chart.y_label);
  std::string plots;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const ChartSeries& series = chart.series[i];
    const std::string data = fmt::format("$series{}", i);
    script += fmt::format("{} << E\n{}E\n", data, DataOf(series));
    if (!series.stddev.empty()) {
      plots += fmt::format(
          "{}{} using 1:3:4 with filledcurves fillcolor rgb '{}' fillstyle transparent solid 0.2 "
          "noborder notitle",
          plots.empty() ? "" : ", ",
          data,
          series.colour);
    }
    plots += fmt::format("{}{} using 1:2 with {} linecolor rgb '{}' title \"{}\"",
                         plots.empty() ? "" : ", ",
                         data,
                         series.style == ChartSeries::Style::kLine
                             ? "linespoints linewidth 2 pointtype 7 pointsize 0.3"
                             : "points pointtype 6 pointsize 0.8",
                         series.colour,
                         series.label);
  }
  return RunGnuplot(script + "plot " + plots + "\n", chart.title);
}

// Front points joined as the stairs that no setting gets below; labels over their points.
std::string DrawScatter(const ScatterChart& chart) {
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
  std::string script =
      "set terminal svg size 760,300 font 'sans,11' noenhanced\n"
      "set border 3\nset tics nomirror\nset logscale x\nset yrange [0:*]\n"
      "set offsets 0, 0, graph 0.08, 0\nset key off\n";
  script += fmt::format("set xlabel \"{}\"\nset ylabel \"{}\"\n", chart.x_label, chart.y_label);
  // Room for the labels on the right.
  script += fmt::format(
      "set xrange [{:.6g}:{:.6g}]\n", 0.9 * least_x, most_x * std::pow(most_x / least_x, 0.15));
  script += "$front << E\n";
  for (const ScatterPoint& point : front)
    script += fmt::format("{:.6g} {:.6g}\n", point.x, point.y);
  script += fmt::format("E\n$all << E\n{}E\n$marked << E\n{}E\n", all, marked);
  std::string plots;
  const auto add = [&](const std::string& plot) { plots += (plots.empty() ? "" : ", ") + plot; };
  if (!front.empty()) add("$front with steps linewidth 1.5 linecolor rgb '#2060c0'");
  const auto add_points = [&](const char* data, const char* colour, const char* style) {
    add(fmt::format(
        "{} using 1:2:3:4:5:6 with xyerrorbars pointtype 7 pointsize {} linecolor rgb '{}'",
        data,
        style,
        colour));
    add(fmt::format(
        "{} using 1:2:7 with labels left offset 0.6,0.6 textcolor rgb '{}'", data, colour));
  };
  if (!all.empty()) add_points("$all", "#606060", "0.4");
  if (!front.empty()) add("$front with points pointtype 7 pointsize 0.6 linecolor rgb '#2060c0'");
  if (!marked.empty()) add_points("$marked", "#c03000", "0.7");
  return RunGnuplot(script + "plot " + plots + "\n", chart.y_label);
}

}  // namespace pleinair
