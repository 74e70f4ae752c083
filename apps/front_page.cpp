#include "apps/front_page.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "apps/chart_page.h"
#include "apps/html_text.h"

namespace pleinair {
namespace {

using Values = std::vector<double> FrontPoint::*;

struct WayOfUse {
  const char* name;
  Values time_ms;
  const char* colour;
  const char* pale;
};

constexpr WayOfUse kWays[] = {{"still", &FrontPoint::still_ms, "#2060c0", "#a0b8dc"},
                              {"moving", &FrontPoint::moving_ms, "#208040", "#a0ccb0"}};

struct FrontError {
  const char* name;
  Values values;
  double unit;
  const char* words;
};

constexpr FrontError kErrors[] = {
    {"picture", &FrontPoint::picture_error, 1.0, "error of the picture, code values"},
    {"light", &FrontPoint::light_error, 100.0, "error of sun and sky, %"}};

// None where the combination has no such name.
std::optional<Quality> QualityOf(const Combination& combination) {
  for (const Quality quality : kAllQualities) {
    bool is_it = true;
    for (std::size_t s = 0; is_it && s < combination.size(); ++s) {
      is_it = combination[s] == QualitySettings()[s].IndexAt(quality);
    }
    if (is_it) return quality;
  }
  return std::nullopt;
}

std::string DifferencesInWords(const Combination& combination) {
  std::string words;
  for (std::size_t s = 0; s < combination.size(); ++s) {
    const QualitySetting& setting = QualitySettings()[s];
    const std::string& text = setting.values[static_cast<std::size_t>(combination[s])];
    if (text == setting.balanced) continue;
    words += (words.empty() ? "" : ", ") + setting.name + " " + text;
  }
  return words;
}

std::vector<FrontPlace> PlacesOf(const FrontPage& page,
                                 const FrontError& error,
                                 const WayOfUse& way) {
  std::vector<TradeoffPoint> points;
  for (const FrontPoint& point : page.points) {
    points.push_back({point.*error.values, point.*way.time_ms});
  }
  return PlacesOnFront(points);
}

Chart ChartOfError(const FrontPage& page, const FrontError& error) {
  Chart chart{"", {"a frame, ms"}, {error.words}, {}};
  ChartSeries named{"", "#c03000", ChartSeries::Style::kPoints, {}, 1.5};
  for (const WayOfUse& way : kWays) {
    const std::vector<FrontPlace> places = PlacesOf(page, error, way);
    ChartSeries front{std::string("front, ") + way.name, way.colour, ChartSeries::Style::kStairs};
    ChartSeries others{"", way.pale, ChartSeries::Style::kPoints, {}, 0.6};
    for (std::size_t i = 0; i < page.points.size(); ++i) {
      const FrontPoint& point = page.points[i];
      const std::optional<Spread> time_ms = SpreadOf(point.*way.time_ms);
      const std::optional<Spread> off = SpreadOf(point.*error.values);
      if (!time_ms || !off) continue;
      ChartPoint drawn{InUnit(*time_ms, 1.0), InUnit(*off, error.unit), ""};
      if (places[i].on_front) {
        front.points.push_back(drawn);
      } else {
        // Without bars, which would hide the front.
        others.points.push_back(
            {ChartValue::Exact(drawn.x.value), ChartValue::Exact(drawn.y.value), ""});
      }
      if (const auto quality = QualityOf(point.combination)) {
        drawn.label = NameOf(*quality);
        named.points.push_back(std::move(drawn));
      }
    }
    std::sort(front.points.begin(), front.points.end(), [](const auto& a, const auto& b) {
      return a.x.value < b.x.value;
    });
    chart.series.push_back(std::move(others));
    chart.series.push_back(std::move(front));
  }
  chart.series.push_back(std::move(named));
  return chart;
}

std::string InWords(const FrontPage& page, std::size_t i, Quality quality) {
  const FrontPoint& point = page.points[i];
  std::string words = std::string(NameOf(quality)) + ":";
  const std::optional<Spread> still = SpreadOf(point.still_ms);
  const std::optional<Spread> moving = SpreadOf(point.moving_ms);
  const std::optional<Spread> picture = SpreadOf(point.picture_error);
  const std::optional<Spread> light = SpreadOf(point.light_error);
  if (!still || !moving || !picture || !light) {
    return words + " could not be measured: " + point.failure;
  }
  words += fmt::format(
      " {:.3g} ms a frame that is still, {:.3g} ms moving; picture off by {:.2f} code values, "
      "light "
      "by {:.2f} %",
      still->median,
      moving->median,
      picture->median,
      100.0 * light->median);
  for (const WayOfUse& way : kWays) {
    const FrontPlace place = PlacesOf(page, kErrors[0], way)[i];
    if (!place.beaten_by) {
      words += fmt::format("; on the front, {}", way.name);
      continue;
    }
    const FrontPoint& other = page.points[*place.beaten_by];
    const std::string differences = DifferencesInWords(other.combination);
    words += fmt::format("; {}, {} has {:.2f} for {:.3g} ms",
                         way.name,
                         differences.empty() ? "balanced" : differences,
                         SpreadOf(other.picture_error)->median,
                         SpreadOf(other.*way.time_ms)->median);
  }
  return words;
}

std::string RowOf(const FrontPage& page, std::size_t i, const std::string& fronts) {
  const FrontPoint& point = page.points[i];
  const auto quality = QualityOf(point.combination);
  const std::string differences = DifferencesInWords(point.combination);
  std::string row = fmt::format("<tr><td{}>{}{}</td>",
                                quality ? " class=\"default\"" : "",
                                quality ? std::string(NameOf(*quality)) + ": " : "",
                                EscapeHtml(differences.empty() ? "run's defaults" : differences));
  const auto cell = [&](Values values, double unit) {
    const std::optional<Spread> spread = SpreadOf(point.*values);
    row += spread ? fmt::format("<td>{:.3g}</td><td>{:.3g} to {:.3g}</td>",
                                unit * spread->median,
                                unit * spread->smallest,
                                unit * spread->largest)
                  : std::string("<td>-</td><td></td>");
  };
  for (const WayOfUse& way : kWays) cell(way.time_ms, 1.0);
  for (const FrontError& error : kErrors) cell(error.values, error.unit);
  return row + "<td>" + (point.failure.empty() ? fronts : EscapeHtml(point.failure)) +
         "</td></tr>\n";
}

std::string TableOf(const FrontPage& page) {
  std::string html =
      "<table><tr><th>other than run's defaults</th><th>still, ms</th><th>spread</th>"
      "<th>moving, ms</th><th>spread</th><th>picture, code values</th><th>spread</th>"
      "<th>light, %</th><th>spread</th><th>fronts</th></tr>\n";
  std::vector<std::string> fronts(page.points.size());
  for (const FrontError& error : kErrors) {
    for (const WayOfUse& way : kWays) {
      const std::vector<FrontPlace> places = PlacesOf(page, error, way);
      for (std::size_t i = 0; i < fronts.size(); ++i) {
        if (!places[i].on_front) continue;
        fronts[i] += fmt::format("{}{} {}", fronts[i].empty() ? "" : ", ", error.name, way.name);
      }
    }
  }
  for (std::size_t i = 0; i < page.points.size(); ++i) {
    if (fronts[i].empty() && !QualityOf(page.points[i].combination)) continue;
    html += RowOf(page, i, fronts[i]);
  }
  return html + "</table>\n";
}

}  // namespace

std::string FrontCsv(const FrontPage& page) {
  std::string csv = "quality";
  for (const QualitySetting& setting : QualitySettings()) csv += "," + setting.name;
  csv += ",seeds";
  for (const char* name : {"picture_error", "light_error", "still_ms", "moving_ms"}) {
    csv += fmt::format(",{0},{0}_smallest,{0}_largest", name);
  }
  csv += ",on_front_still,on_front_moving,failure\n";
  const std::vector<FrontPlace> still = PlacesOf(page, kErrors[0], kWays[0]);
  const std::vector<FrontPlace> moving = PlacesOf(page, kErrors[0], kWays[1]);
  for (std::size_t i = 0; i < page.points.size(); ++i) {
    const FrontPoint& point = page.points[i];
    const auto quality = QualityOf(point.combination);
    csv += quality ? NameOf(*quality) : "";
    for (std::size_t s = 0; s < point.combination.size(); ++s) {
      csv += "," + QualitySettings()[s].values[static_cast<std::size_t>(point.combination[s])];
    }
    csv += fmt::format(",{}", point.still_ms.size());
    for (const Values values : {&FrontPoint::picture_error,
                                &FrontPoint::light_error,
                                &FrontPoint::still_ms,
                                &FrontPoint::moving_ms}) {
      const std::optional<Spread> spread = SpreadOf(point.*values);
      csv += spread
                 ? fmt::format(
                       ",{:.5g},{:.5g},{:.5g}", spread->median, spread->smallest, spread->largest)
                 : std::string(",,,");
    }
    csv += fmt::format(",{},{},{}\n",
                       still[i].on_front ? 1 : 0,
                       moving[i].on_front ? 1 : 0,
                       point.failure.empty() ? std::string() : CsvText(point.failure));
  }
  return csv;
}

std::string QualitiesInWords(const FrontPage& page) {
  std::string text;
  for (const Quality quality : kAllQualities) {
    for (std::size_t i = 0; i < page.points.size(); ++i) {
      if (QualityOf(page.points[i].combination) != quality) continue;
      text += InWords(page, i, quality) + "\n";
    }
  }
  return text;
}

std::string FrontChart(const FrontPage& page) {
  std::vector<Chart> charts;
  for (const FrontError& error : kErrors) charts.push_back(ChartOfError(page, error));
  return ChartsForPage(charts);
}

std::string FrontHtml(const FrontPage& page) {
  std::string html = ChartPageHead(page.title) + "<ul>\n";
  for (const std::string& line : page.settings) html += "<li>" + EscapeHtml(line) + "</li>\n";
  html +=
      "</ul>\n<p>Each point is a combination of settings: the median over seeds, on the fronts "
      "with "
      "smallest and largest. No combination that was tried lies left of a front and below it. "
      "Still: the same frame again. Moving: each frame from another direction. Red: "
      "<code>run --quality</code>.</p>\n" +
      FrontChart(page) + "\n<ul>\n";
  for (const Quality quality : kAllQualities) {
    const std::string words = QualityInWords(quality);
    html += fmt::format(
        "<li>{}: {}</li>\n", NameOf(quality), EscapeHtml(words.empty() ? "run's defaults" : words));
  }
  html += "</ul>\n<pre style=\"white-space: pre-wrap\">" + EscapeHtml(QualitiesInWords(page)) +
          "</pre>\n" + TableOf(page);
  return html + "</body></html>\n";
}

}  // namespace pleinair
