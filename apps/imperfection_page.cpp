#include "apps/imperfection_page.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "apps/chart_page.h"
#include "apps/html_text.h"

namespace pleinair {
namespace {

using Figure = std::optional<double> ImperfectionFigures::*;

// The two errors that are drawn.
struct Judged {
  Figure figure;
  double unit;  // From the figure's to the chart's.
  const char* words;
  const char* added_words;
};

constexpr Judged kLight{&ImperfectionFigures::sun_over_sky,
                        100.0,
                        "error of sun over sky, %",
                        "added error of sun over sky, %"};
constexpr Judged kPicture{&ImperfectionFigures::object_codes,
                          1.0,
                          "error of objects, code values",
                          "added error of objects, code values"};

constexpr std::array<const char*, 6> kColours{
    "#2060c0", "#c03000", "#208040", "#8040a0", "#a07000", "#008080"};

std::optional<Spread> SpreadOverRuns(const ImperfectionResult& result, Figure figure) {
  std::vector<double> values;
  for (const ImperfectionFigures& run : result.runs) {
    if (run.*figure) values.push_back(*(run.*figure));
  }
  return SpreadOf(values);
}

const ImperfectionResult* AtSize(const std::vector<ImperfectionResult>& results, double size) {
  const auto found = std::find_if(
      results.begin(), results.end(), [size](const auto& result) { return result.size == size; });
  return found == results.end() ? nullptr : &*found;
}

// The cost of a dial at one of its sizes, over recordings and seeds.
struct Cost {
  std::optional<Spread> with;
  std::optional<Spread> without;
  std::optional<Spread> added;  // Seed by seed.
};

Cost CostOf(const ImperfectionPage& page, std::size_t dial, double size, Figure figure) {
  std::vector<double> with;
  std::vector<double> without;
  std::vector<double> added;
  for (const ImperfectRecording& recording : page.recordings) {
    const ImperfectionResult* result = AtSize(recording.dials[dial], size);
    const ImperfectionResult& base = recording.BaseOf(page.dials[dial]);
    if (result == nullptr) continue;
    for (std::size_t s = 0; s < std::min(result->runs.size(), base.runs.size()); ++s) {
      const std::optional<double>& is = result->runs[s].*figure;
      const std::optional<double>& was = base.runs[s].*figure;
      if (!is || !was) continue;
      with.push_back(*is);
      without.push_back(*was);
      added.push_back(*is - *was);
    }
  }
  return {SpreadOf(with), SpreadOf(without), SpreadOf(added)};
}

// The costliest for the light first.
std::vector<std::size_t> ByCost(const ImperfectionPage& page) {
  std::vector<double> costs;
  for (std::size_t dial = 0; dial < page.dials.size(); ++dial) {
    const std::optional<Spread> added =
        CostOf(page, dial, page.dials[dial].usual, kLight.figure).added;
    costs.push_back(added ? added->median : 0.0);
  }
  std::vector<std::size_t> order(page.dials.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return costs[a] > costs[b];
  });
  return order;
}

std::string WithUnit(const ImperfectionDial& dial, double size) {
  const char* space = dial.unit.empty() || dial.unit == "°" ? "" : " ";
  return fmt::format("{:g}{}{}", size, space, dial.unit);
}

std::string InWords(const ImperfectionPage& page, std::size_t dial) {
  const Cost light = CostOf(page, dial, page.dials[dial].usual, kLight.figure);
  const Cost picture = CostOf(page, dial, page.dials[dial].usual, kPicture.figure);
  std::string text =
      page.dials[dial].words + " " + WithUnit(page.dials[dial], page.dials[dial].usual) + ":";
  if (light.with) {
    text += fmt::format(" sun over sky is {:.1f} % off instead of {:.1f} %",
                        100.0 * light.with->median,
                        100.0 * light.without->median);
  }
  if (picture.with) {
    text += fmt::format("{} objects {:.1f} code values instead of {:.1f}",
                        light.with ? "," : "",
                        picture.with->median,
                        picture.without->median);
  }
  return light.with || picture.with ? text : text + " not measured";
}

Chart OverviewChart(const ImperfectionPage& page,
                    const std::vector<std::size_t>& order,
                    const Judged& judged) {
  Chart chart{"", {judged.added_words}, {"", ChartAxis::Scale::kByValues, {}}, {}};
  ChartSeries series{"", kColours[0], ChartSeries::Style::kPoints, {}, 1.3};
  ChartSeries none{"", "#606060", ChartSeries::Style::kDashes, {}};
  for (const std::size_t dial : order) {
    chart.y.categories.push_back(page.dials[dial].label + " " +
                                 WithUnit(page.dials[dial], page.dials[dial].usual));
    const auto place = static_cast<double>(chart.y.categories.size());
    const std::optional<Spread> added =
        CostOf(page, dial, page.dials[dial].usual, judged.figure).added;
    if (added) {
      series.points.push_back({InUnit(*added, judged.unit), ChartValue::Exact(place), ""});
    }
  }
  const double places = static_cast<double>(chart.y.categories.size());
  none.points = {{ChartValue::Exact(0.0), ChartValue::Exact(0.5), ""},
                 {ChartValue::Exact(0.0), ChartValue::Exact(places + 0.5), ""}};
  chart.series = {std::move(none), std::move(series)};
  return chart;
}

Chart DialChart(const ImperfectionPage& page, std::size_t dial, const Judged& judged) {
  const ImperfectionDial& turned = page.dials[dial];
  const std::string unit = turned.unit.empty() ? "" : ", " + turned.unit;
  Chart chart{"", {turned.label + unit}, {judged.words}, {}};
  for (std::size_t r = 0; r < page.recordings.size(); ++r) {
    const ImperfectRecording& recording = page.recordings[r];
    const char* colour = kColours[r % kColours.size()];
    ChartSeries series{recording.name, colour};
    for (const ImperfectionResult& result : recording.dials[dial]) {
      const std::optional<Spread> spread = SpreadOverRuns(result, judged.figure);
      if (!spread) continue;
      series.points.push_back({ChartValue::Exact(result.size), InUnit(*spread, judged.unit), ""});
    }
    if (series.points.empty()) continue;
    ChartSeries without{"", colour, ChartSeries::Style::kDashes};
    if (const auto base = SpreadOverRuns(recording.BaseOf(turned), judged.figure)) {
      const ChartValue level = ChartValue::Exact(judged.unit * base->median);
      without.points = {{series.points.front().x, level, ""}, {series.points.back().x, level, ""}};
    }
    chart.series.push_back(std::move(series));
    chart.series.push_back(std::move(without));
  }
  return chart;
}

std::string ChartsOf(const ImperfectionPage& page, std::size_t dial) {
  std::vector<Chart> charts;
  for (const Judged& judged : {kLight, kPicture}) {
    Chart chart = DialChart(page, dial, judged);
    if (!chart.series.empty()) charts.push_back(std::move(chart));
  }
  return charts.empty() ? std::string() : ChartsForPage(charts);
}

std::string Cell(const std::optional<Spread>& spread, double unit) {
  if (!spread) return "<td>-</td>";
  return fmt::format("<td>{:.3g} ({:.3g} to {:.3g})</td>",
                     unit * spread->median,
                     unit * spread->smallest,
                     unit * spread->largest);
}

std::string RowOf(const std::string& recording,
                  const std::string& size,
                  const ImperfectionResult& result) {
  std::string row = fmt::format("<tr><td>{}</td><td>{}</td>", EscapeHtml(recording), size);
  row += Cell(SpreadOverRuns(result, kLight.figure), kLight.unit);
  row += Cell(SpreadOverRuns(result, &ImperfectionFigures::sun), 100.0);
  row += Cell(SpreadOverRuns(result, &ImperfectionFigures::sky), 100.0);
  row += Cell(SpreadOverRuns(result, kPicture.figure), kPicture.unit);
  return row + fmt::format("<td class=\"bad\">{}</td></tr>\n", EscapeHtml(result.failure));
}

std::string TableOf(const ImperfectionPage& page, std::size_t dial) {
  std::string html =
      "<table><tr><th>recording</th><th>size</th><th>sun over sky, %</th><th>sun, %</th>"
      "<th>sky, %</th><th>objects, code values</th><th></th></tr>\n";
  for (const ImperfectRecording& recording : page.recordings) {
    html += RowOf(recording.name, "without", recording.BaseOf(page.dials[dial]));
    for (const ImperfectionResult& result : recording.dials[dial]) {
      html += RowOf(recording.name, WithUnit(page.dials[dial], result.size), result);
    }
  }
  return html + "</table>\n";
}

std::string CsvLine(const std::string& recording,
                    const std::string& dial,
                    const ImperfectionResult& result) {
  std::string line =
      fmt::format("{},{},{:g},{}", CsvText(recording), dial, result.size, result.runs.size());
  for (const Figure figure : {&ImperfectionFigures::sun_over_sky,
                              &ImperfectionFigures::sun,
                              &ImperfectionFigures::sky,
                              &ImperfectionFigures::object_codes}) {
    const std::optional<Spread> spread = SpreadOverRuns(result, figure);
    line += spread ? fmt::format(
                         ",{:.5g},{:.5g},{:.5g}", spread->median, spread->smallest, spread->largest)
                   : std::string(",,,");
  }
  return line + "," + (result.failure.empty() ? "" : CsvText(result.failure)) + "\n";
}

}  // namespace

std::string ImperfectionCsv(const ImperfectionPage& page) {
  std::string csv = "recording,imperfection,size,seeds";
  for (const char* figure : {"sun_over_sky_log_error", "sun_error", "sky_error", "object_codes"}) {
    csv += fmt::format(",{0},{0}_smallest,{0}_largest", figure);
  }
  csv += ",failure\n";
  for (const ImperfectRecording& recording : page.recordings) {
    csv += CsvLine(recording.name, "none", recording.perfect);
    if (!recording.without_map.runs.empty()) {
      csv += CsvLine(recording.name, "no map", recording.without_map);
    }
    for (std::size_t dial = 0; dial < page.dials.size(); ++dial) {
      for (const ImperfectionResult& result : recording.dials[dial]) {
        csv += CsvLine(recording.name, page.dials[dial].name, result);
      }
    }
  }
  return csv;
}

std::string ImperfectionsInWords(const ImperfectionPage& page) {
  std::string text;
  for (const std::size_t dial : ByCost(page)) text += InWords(page, dial) + "\n";
  return text;
}

std::string ImperfectionOverview(const ImperfectionPage& page) {
  const std::vector<std::size_t> order = ByCost(page);
  std::vector<Chart> charts;
  for (const Judged& judged : {kLight, kPicture}) {
    Chart chart = OverviewChart(page, order, judged);
    if (!chart.series.back().points.empty()) charts.push_back(std::move(chart));
  }
  return charts.empty() ? std::string() : ChartsForPage(charts);
}

std::string ImperfectionMarkdown(const ImperfectionPage& page) {
  std::string text =
      "# What imperfections cost\n\nWritten by `pleinair tradeoff --sweep imperfections`.\n";
  for (const std::string& line : page.settings) text += "- " + line + "\n";
  text += "\n![added errors](imperfections.svg)\n\nOne at a time, at its usual size:\n\n";
  for (const std::size_t dial : ByCost(page)) text += "- " + InWords(page, dial) + "\n";
  text +=
      "\nError of sun over sky in per cent (|log|) / of objects in code values, by size:\n\n"
      "| imperfection | without | | | | | |\n| --- | --- | --- | --- | --- | --- | --- |\n";
  const auto number = [](const std::optional<Spread>& spread, double unit) {
    return spread ? fmt::format("{:.1f}", unit * spread->median) : std::string("-");
  };
  for (std::size_t dial = 0; dial < page.dials.size(); ++dial) {
    const ImperfectionDial& turned = page.dials[dial];
    text += "| " + turned.name;
    for (const double size : turned.sizes) {
      const Cost light = CostOf(page, dial, size, kLight.figure);
      const Cost picture = CostOf(page, dial, size, kPicture.figure);
      if (size == turned.sizes.front()) {
        text += fmt::format(" | {} / {}",
                            number(light.without, kLight.unit),
                            number(picture.without, kPicture.unit));
      }
      text += fmt::format(" | {}: **{} / {}**",
                          WithUnit(turned, size),
                          number(light.with, kLight.unit),
                          number(picture.with, kPicture.unit));
    }
    text += " |\n";
  }
  return text;
}

std::string ImperfectionHtml(const ImperfectionPage& page) {
  std::string html = ChartPageHead("What imperfections cost") + "<ul>\n";
  for (const std::string& line : page.settings) html += "<li>" + EscapeHtml(line) + "</li>\n";
  html +=
      "</ul>\n<p>One imperfection at a time, the others absent. Points are medians over seeds, "
      "bars "
      "their smallest and largest; dashed lines are the recording without the imperfection. The "
      "error of the light is |log| of sun over sky against the truth, that of objects the root "
      "mean square over their pixels against the object really there.</p>\n"
      "<h2>Each at its usual size</h2>\n<ul>\n";
  const std::vector<std::size_t> order = ByCost(page);
  for (const std::size_t dial : order) {
    html += fmt::format("<li><a href=\"#{}\">{}</a></li>\n",
                        page.dials[dial].name,
                        EscapeHtml(InWords(page, dial)));
  }
  html += "</ul>\n" + ImperfectionOverview(page) + "\n";
  for (const std::size_t dial : order) {
    html += fmt::format("<h2 id=\"{0}\">{0}</h2>\n<p>{1} ...</p>\n",
                        page.dials[dial].name,
                        EscapeHtml(page.dials[dial].words));
    html += WithoutDefinitions(ChartsOf(page, dial)) + "\n" + TableOf(page, dial);
  }
  return html + "</body></html>\n";
}

}  // namespace pleinair
