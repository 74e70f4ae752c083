#include "apps/site_import_command.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "apps/number_table.h"
#include "scene/whole_file.h"
#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair {
namespace {

std::string WithoutBlanks(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

std::vector<std::string> Fields(std::string_view text) {
  std::vector<std::string> fields;
  while (true) {
    const std::size_t comma = text.find(',');
    fields.push_back(WithoutBlanks(text.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    text.remove_prefix(comma + 1);
  }
}

// The text after the first comma: numbers.
std::vector<double> NumbersAfterName(std::string_view text, const std::string& what) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return {};
  return ParseNumbers(text.substr(comma + 1), what);
}

// Lines of a CSV file with something in them, `#` begins a remark; `use` may throw.
template <typename Use>
void ForEachRow(const std::filesystem::path& file, const Use& use) {
  RequireFile(file);
  std::ifstream stream(file);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line.resize(std::min(line.find('#'), line.size()));
    if (WithoutBlanks(line).empty()) continue;
    try {
      use(line, number);
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(fmt::format("{}:{}: {}", file.string(), number, error.what()));
    }
  }
}

KnownLength ParseLength(double length_m, const std::string& between) {
  constexpr const char* kExpected = ": expected ID,ID or PICTURE,X1,Y1,X2,Y2";
  KnownLength known;
  known.length_m = length_m;
  const std::vector<std::string> fields = Fields(between);
  if (fields.size() == 2) {
    PointPair pair;
    for (const auto& [text, id] :
         {std::pair{&fields[0], &pair.first}, {&fields[1], &pair.second}}) {
      const char* end = text->data() + text->size();
      const auto [stop, error] = std::from_chars(text->data(), end, *id);
      if (error != std::errc() || stop != end) {
        throw std::invalid_argument("--between " + between + kExpected);
      }
    }
    known.between = pair;
    return known;
  }
  const std::vector<double> pixels = NumbersAfterName(between, "--between");
  if (pixels.size() != 4) throw std::invalid_argument("--between " + between + kExpected);
  known.between = PickPair{fields[0], {pixels[0], pixels[1]}, {pixels[2], pixels[3]}};
  return known;
}

StatedHeading ParseHeading(const std::string& text) {
  constexpr double kUsualSigmaDeg = 10.0;
  const std::vector<double> numbers = NumbersAfterName(text, "--heading");
  if (numbers.empty() || numbers.size() > 2 || !(std::abs(numbers[0]) <= 360.0) ||
      (numbers.size() == 2 && !(numbers[1] > 0.0 && numbers[1] <= 180.0))) {
    throw std::invalid_argument(
        "--heading " + text +
        ": expected PICTURE,DEG or PICTURE,DEG,SIGMA with an azimuth within 360 and a deviation "
        "above 0 degrees");
  }
  return {Fields(text).front(),
          RadFromDeg(numbers[0]),
          RadFromDeg(numbers.size() == 2 ? numbers[1] : kUsualSigmaDeg)};
}

std::chrono::minutes ParseOffset(const std::string& text) {
  try {
    return std::chrono::duration_cast<std::chrono::minutes>(
        ParseUtcTime("2000-01-01T00:00:00Z") - ParseUtcTime("2000-01-01T00:00:00" + text));
  } catch (const std::invalid_argument&) {
    throw std::invalid_argument("--utc-offset " + text +
                                ": expected what local time is ahead of UTC, such as +02:00 or Z");
  }
}

std::map<std::string, UtcTime> ReadTimes(const std::filesystem::path& file) {
  std::map<std::string, UtcTime> times;
  ForEachRow(file, [&](const std::string& line, int number) {
    const std::vector<std::string> fields = Fields(line);
    if (fields.size() < 2) throw std::invalid_argument("expected PICTURE,TIME");
    const bool is_heading =
        number == 1 && fields[1].find_first_of("0123456789") == std::string::npos;
    if (!is_heading) times[fields[0]] = ParseUtcTime(fields[1]);
  });
  return times;
}

// Names of groups in an OBJ file.
bool IsGroupName(const std::string& name) {
  return !name.empty() && name.find_first_of(" \t#\\/") == std::string::npos;
}

std::vector<PictureMark> ReadMarks(const std::filesystem::path& file) {
  std::vector<PictureMark> marks;
  ForEachRow(file, [&](const std::string& line, int) {
    const std::vector<std::string> fields = Fields(line);
    if (fields.size() != 4 || !IsGroupName(fields[3])) {
      throw std::invalid_argument(
          "expected PICTURE,X,Y,SURFACE, with a surface's name of one word");
    }
    const std::vector<double> pixel = ParseNumbers(fields[1] + "," + fields[2], "pixel");
    marks.push_back({fields[0], {pixel[0], pixel[1]}, fields[3]});
  });
  if (marks.empty()) {
    throw std::runtime_error(file.string() + ": expected a line PICTURE,X,Y,SURFACE, found none");
  }
  return marks;
}

std::string DescribeNorth(const GeoAlignment& earth) {
  if (earth.turn_sigma_rad >= RadFromDeg(180.0)) {
    return "north    unknown: no positions or compass readings determine it; give --heading\n";
  }
  std::string text = fmt::format("north    sigma {:.1f} deg", DegFromRad(earth.turn_sigma_rad));
  if (earth.turn_by_positions_rad && earth.turn_by_headings_rad) {
    text += fmt::format(
        ", by positions and headings, which differ by {:.1f} deg",
        std::abs(DegFromRad(std::remainder(
            *earth.turn_by_positions_rad - *earth.turn_by_headings_rad, RadFromDeg(360.0)))));
  } else {
    text += earth.turn_by_positions_rad ? ", by positions" : ", by headings";
  }
  return text + "\n";
}

std::string DescribeSurface(const SiteSurface& surface) {
  glm::dvec3 lower(std::numeric_limits<double>::infinity());
  glm::dvec3 upper(-lower);
  for (const auto& polygon : surface.polygons) {
    for (const glm::dvec3& corner : polygon) {
      lower = glm::min(lower, corner);
      upper = glm::max(upper, corner);
    }
  }
  const glm::dvec3 size = upper - lower;
  const glm::dvec3& n = surface.plane.normal;
  return fmt::format("{:<16} {:>6} {:>7.3f} {:>8.1f} {:>8.1f} {:>9.1f} {:>9.1f}\n",
                     surface.name,
                     surface.points,
                     surface.rms_m,
                     std::fmod(DegFromRad(std::atan2(n.x, n.y)) + 360.0, 360.0),
                     DegFromRad(std::atan2(n.z, std::hypot(n.x, n.y))),
                     std::hypot(size.x, size.y),
                     size.z);
}

std::string Describe(const SiteImportReport& report, const SiteImportCommandOptions& options) {
  std::string text = fmt::format(
      "{} pictures, {} points, {} frames\n", report.pictures, report.points, report.frames);
  text += fmt::format("up       sigma {:.1f} deg\n", DegFromRad(report.up.sigma_rad));
  text += fmt::format("scale    {:.4f} m per unit", report.metres_per_unit);
  text += options.length_m ? ", by the known length\n"
                           : fmt::format(", by positions: sigma {:.0f} % (--length)\n",
                                         100.0 * report.earth.scale_sigma);
  text += DescribeNorth(report.earth);
  text += fmt::format("place    {:.6f}, {:.6f}, {:.0f} m",
                      DegFromRad(report.site.latitude_rad),
                      DegFromRad(report.site.longitude_rad),
                      report.site.height_m);
  text += report.earth.has_position
              ? fmt::format("; positions are {:.1f} m (rms) from the cameras\n",
                            report.earth.position_rms_m)
              : "\n";
  text += "\nsurface          points   rms m  faces deg  up deg  length m  height m\n";
  for (const SiteSurface& surface : report.surfaces) text += DescribeSurface(surface);
  text += "\n";
  for (const std::string& note : report.notes) text += "note: " + note + "\n";
  const std::string out = options.import.out.string();
  text += fmt::format(
      "next: pleinair site place {0} --object MESH --pixel X,Y\n"
      "      pleinair calibrate north {0}   (by shadows; `run` uses them, too)\n"
      "      pleinair run {0} --out RESULT\n",
      out);
  return text;
}

}  // namespace

std::string RunSiteImport(const SiteImportCommandOptions& options) {
  SiteImportOptions import = options.import;
  if (options.length_m.has_value() != !options.between.empty()) {
    throw std::invalid_argument(
        "expected --length METRES together with --between, which says where it is");
  }
  if (options.length_m) import.length = ParseLength(*options.length_m, options.between);
  if (!options.site.empty()) import.site = ParseSite(options.site);
  for (const std::string& heading : options.headings) {
    import.headings.push_back(ParseHeading(heading));
  }
  if (!options.utc_offset.empty()) import.utc_offset = ParseOffset(options.utc_offset);
  if (!options.times.empty()) import.times = ReadTimes(options.times);
  if (!options.marks.empty()) import.marks = ReadMarks(options.marks);
  return Describe(ImportSite(import), options);
}

}  // namespace pleinair
