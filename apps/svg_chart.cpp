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
#include <spdlog/spdlog.h>

#include "apps/html_text.h"

namespace pleinair {
namespace {

constexpr int kWidthPx = 520;
constexpr int kHeightPx = 330;
constexpr int kCategoryPx = 24;       // Height of a name on an upright axis of names.
constexpr int kAroundPx = 110;        // Its title, marks and key.
constexpr int kFontPx = 14;           // On a phone 360 px wide it is shown with 10.
constexpr double kFarApart = 4.0;     // Largest over smallest, from which a scale is logarithmic.
constexpr double kMargin = 0.06;      // Share of the range, left free at the ends of an axis.
constexpr double kLabelMargin = 0.2;  // The same right of points with labels.

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
  std::string without_settings_of_users = "-d";
  std::string from_standard_input = "-";
  const std::array<char*, 4> arguments{
      program.data(), without_settings_of_users.data(), from_standard_input.data(), nullptr};
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

// Quotes text so that gnuplot reads it unchanged: in single quotes nothing is replaced or run.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "'";
}

// For data, where no quote can be escaped.
std::string DataText(std::string text) {
  for (char& c : text) {
    if (c == '"' || c == '\\' || c == '\n') c = ' ';
  }
  return '"' + text + '"';
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  bool is_logarithmic = false;
};

Range RangeOf(const Chart& chart, ChartValue ChartPoint::*of_point, const ChartAxis& axis) {
  Range range;
  bool has_labels = false;
  for (const ChartSeries& series : chart.series) {
    for (const ChartPoint& point : series.points) {
      const ChartValue& value = point.*of_point;
      has_labels = has_labels || !point.label.empty();
      for (const double end : {value.value, value.low, value.high}) {
        if (!std::isfinite(end)) continue;
        range.low = std::min(range.low, end);
        range.high = std::max(range.high, end);
      }
    }
  }
  if (!(range.low <= range.high)) throw std::runtime_error("chart: no point to draw");
  if (!axis.categories.empty()) {
    range.low = 0.5;
    range.high = static_cast<double>(axis.categories.size()) + 0.5;
    return range;
  }
  const double beyond = of_point == &ChartPoint::x && has_labels ? kLabelMargin : kMargin;
  if (axis.scale == ChartAxis::Scale::kByValues && range.low > 0.0 &&
      range.high >= kFarApart * range.low) {
    range.is_logarithmic = true;
    const double span = range.high / range.low;
    range.low *= std::pow(span, -kMargin);
    range.high *= std::pow(span, beyond);
    return range;
  }
  if (axis.scale == ChartAxis::Scale::kFromZero) range.low = std::min(0.0, range.low);
  double span = range.high - range.low;
  if (!(span > 0.0)) span = std::max(1e-6, 0.2 * std::abs(range.high));  // One value.
  if (range.low != 0.0) range.low -= kMargin * span;
  range.high += beyond * span;
  return range;
}

// Round, and so long that at most seven marks have room.
double LinearStep(double span) {
  constexpr double kMostSteps = 6.0;
  const double decade = std::pow(10.0, std::floor(std::log10(span / kMostSteps)));
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (digit * decade * kMostSteps >= span) return digit * decade;
  }
  return 10.0 * decade;
}

void WriteAxis(const char* name, const ChartAxis& axis, const Range& range, std::string& script) {
  const bool from_top = name[0] == 'y' && !axis.categories.empty();
  script += fmt::format("unset logscale {0}\nset {0}label {1}\n", name, Quoted(axis.label));
  script += fmt::format("set {}range [{:.8g}:{:.8g}] noextend\n",
                        name,
                        from_top ? range.high : range.low,
                        from_top ? range.low : range.high);
  std::string marks;
  const auto add = [&marks](const std::string& text, double at) {
    marks += fmt::format("{}{} {:.8g}", marks.empty() ? "" : ", ", Quoted(text), at);
  };
  if (!axis.categories.empty()) {
    for (std::size_t i = 0; i < axis.categories.size(); ++i) {
      add(axis.categories[i], static_cast<double>(i) + 1.0);
    }
  } else if (range.is_logarithmic) {
    script += fmt::format("set logscale {}\n", name);
    for (const double mark : LogarithmicMarks(range.low, range.high)) {
      add(fmt::format("{:.6g}", mark), mark);
    }
  }
  if (marks.empty()) {
    script += fmt::format("set {}tics {:.8g} nomirror\n", name, LinearStep(range.high - range.low));
  } else {
    script += fmt::format("set {}tics ({}) nomirror\n", name, marks);
  }
}

// gnuplot's rows of a series; an empty line breaks the curve.
std::string DataOf(const ChartSeries& series) {
  std::string rows;
  for (const ChartPoint& point : series.points) {
    if (!std::isfinite(point.x.value) || !std::isfinite(point.y.value)) {
      rows += "\n";
      continue;
    }
    rows += fmt::format("{:.8g} {:.8g} {:.8g} {:.8g} {:.8g} {:.8g} {}\n",
                        point.x.value,
                        point.y.value,
                        point.x.low,
                        point.x.high,
                        point.y.low,
                        point.y.high,
                        DataText(point.label));
  }
  return rows;
}

// What `plot` is given for a series; its data are in the block `data`.
std::string PlotsOf(const ChartSeries& series, const std::string& data) {
  std::string plots;
  const auto add = [&](const std::string& columns, const std::string& style) {
    plots += fmt::format("{}{} using {} with {} linecolor rgb '{}' ",
                         plots.empty() ? "" : ", ",
                         data,
                         columns,
                         style,
                         series.colour);
  };
  const std::string title =
      series.label.empty() ? "notitle" : "title " + Quoted(series.label) + " noenhanced";
  const auto is_exact = [](const ChartValue& value) { return value.low == value.high; };
  bool has_bars = false;
  bool has_labels = false;
  for (const ChartPoint& point : series.points) {
    has_bars = has_bars || !is_exact(point.x) || !is_exact(point.y);
    has_labels = has_labels || !point.label.empty();
  }
  const std::string points =
      fmt::format("points pointtype 7 pointsize {:.3g}", 0.6 * series.point_size);
  switch (series.style) {
    case ChartSeries::Style::kBand:
      if (has_bars) {
        add("1:5:6", "filledcurves fillstyle transparent solid 0.2 noborder");
        plots += "notitle";
      }
      add("1:2", "linespoints linewidth 2 pointtype 7 pointsize 0.4");
      break;
    case ChartSeries::Style::kStairs:
      add("1:2", "steps linewidth 2");
      plots += "notitle";
      add("1:2", points);
      break;
    case ChartSeries::Style::kLine:
      add("1:2", fmt::format("linespoints linewidth 2 pointtype 7 pointsize 0.5"));
      break;
    case ChartSeries::Style::kDashes:
      add("1:2", "lines dashtype 2 linewidth 1.5");
      break;
    case ChartSeries::Style::kPoints:
      add("1:2", points);
      break;
  }
  plots += title;
  const bool draws_bars =
      series.style != ChartSeries::Style::kBand && series.style != ChartSeries::Style::kDashes;
  if (has_bars && draws_bars) {
    add("1:2:3:4:5:6", "xyerrorbars pointtype -1 linewidth 1");
    plots += "notitle";
  }
  if (has_labels) {
    plots += fmt::format(
        ", {} using 1:2:7 with labels noenhanced left offset 0.6,0.6 textcolor rgb '{}' notitle",
        data,
        series.colour);
  }
  return plots;
}

int HeightPx(const Chart& chart) {
  if (chart.y.categories.empty()) return kHeightPx;
  return kAroundPx + kCategoryPx * static_cast<int>(chart.y.categories.size());
}

void WriteChart(const Chart& chart, std::size_t number, std::string& script) {
  if (chart.title.empty()) {
    script += "unset title\n";
  } else {
    script += fmt::format("set title {} noenhanced\n", Quoted(chart.title));
  }
  WriteAxis("x", chart.x, RangeOf(chart, &ChartPoint::x, chart.x), script);
  WriteAxis("y", chart.y, RangeOf(chart, &ChartPoint::y, chart.y), script);
  std::string plots;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    if (chart.series[i].points.empty()) continue;
    const std::string data = fmt::format("$data{}_{}", number, i);
    script += fmt::format("{} << E\n{}E\n", data, DataOf(chart.series[i]));
    plots += (plots.empty() ? "" : ", ") + PlotsOf(chart.series[i], data);
  }
  script += fmt::format("plot {}\n", plots);
}

}  // namespace

std::vector<double> LogarithmicMarks(double low, double high) {
  static const std::vector<std::vector<double>> kDigits = {
      {1}, {1, 3}, {1, 2, 5}, {1, 1.5, 2, 3, 5, 7}, {1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9}};
  constexpr std::size_t kEnough = 4;
  std::vector<double> marks;
  for (const std::vector<double>& digits : kDigits) {
    marks.clear();
    for (int decade = static_cast<int>(std::floor(std::log10(low)));
         decade <= static_cast<int>(std::floor(std::log10(high)));
         ++decade) {
      for (const double digit : digits) {
        const double mark = digit * std::pow(10.0, decade);
        if (mark >= low && mark <= high) marks.push_back(mark);
      }
    }
    if (marks.size() >= kEnough) break;
  }
  return marks;
}

std::string DrawChart(const Chart& chart) { return DrawCharts(std::span(&chart, 1)); }

std::string DrawCharts(std::span<const Chart> charts) {
  if (charts.empty()) throw std::runtime_error("charts: none to draw");
  int height_px = 0;
  for (const Chart& chart : charts) height_px += HeightPx(chart);
  std::string script =
      fmt::format("set terminal svg noenhanced size {},{} font 'sans,{}' background '#ffffff'\n",
                  kWidthPx,
                  height_px,
                  kFontPx);
  script += "set encoding utf8\nset grid\nset key below\nset border 3\nset format '%h'\n";
  if (charts.size() > 1) script += "set multiplot\n";
  int above_px = 0;
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const int this_px = HeightPx(charts[i]);
    above_px += this_px;
    script += fmt::format("set size 1,{:.6g}\nset origin 0,{:.6g}\n",
                          double(this_px) / height_px,
                          1.0 - double(above_px) / height_px);
    // Scales of charts under one another begin at one place.
    const bool has_names = !charts[i].y.categories.empty();
    script += charts.size() > 1 && !has_names ? "set lmargin 9\n" : "unset lmargin\n";
    WriteChart(charts[i], i, script);
  }
  if (charts.size() > 1) script += "unset multiplot\n";
  const Chart& first = charts.front();
  return RunGnuplot(script, first.title.empty() ? first.y.label : first.title);
}

std::string ChartsForPage(std::span<const Chart> charts) {
  try {
    return DrawCharts(charts);
  } catch (const std::runtime_error& error) {
    spdlog::warn("{}: the page is without it", error.what());
    return "<p class=\"bad\">" + EscapeHtml(error.what()) + "</p>";
  }
}

}  // namespace pleinair
