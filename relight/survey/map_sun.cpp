#include "relight/survey/map_sun.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

#include "relight/survey/internal/map_pixels.h"
#include "scene/lat_long.h"
#include "scene/sun_in_picture.h"
#include "scene/upper_median.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr int kSpots = 16;  // The brightest ones, which are compared by their light.
constexpr double kSpotRad = RadFromDeg(1.0);
constexpr double kBetweenSpotsRad = RadFromDeg(2.0);
// The sky around a spot: outside the glare of a sun, inside what a cloud is wide.
constexpr double kAroundFromRad = RadFromDeg(5.0);
constexpr double kAroundToRad = RadFromDeg(12.0);

// A disc is 0.27 deg in radius; lenses and a map's pixels spread it.
constexpr double kLargestDiscRad = RadFromDeg(0.8);
// A lamp of a real room has 6 % of its light, a clear low sun four times the sky's.
constexpr double kLeastDiscShare = 0.1;
constexpr double kLeastDiscContrast = 10.0;

constexpr int kLeastFlatPixels = 3;
constexpr double kLeastFlatContrast = 2.5;
// An unclipped lamp of even brightness is flat, too, and far brighter than any limit that a sun is
// cut at but for one that lets it keep its share.
constexpr double kMostFlatContrast = 100.0;

// From four real panoramas whose suns are cut at 3 to 20 times the brightest hundredth of the sky:
//                               suns          no suns
//   radius at half height, deg  1.0 to 5.4    7 (a room's window)
//   contrast                    3 to 55       up to 2 (clouds that hide the sun)
//   share of the light, %       5 to 25
//   length over width           up to 2.1     4 to 6 (clouds before a low sun), 8 (a window)
//   light near it over farther  1.5 to 4.9    1.0 (a window)
constexpr double kSmallestGlowRad = RadFromDeg(0.75);
constexpr double kLargestGlowRad = RadFromDeg(5.5);
constexpr double kLeastGlowContrast = 3.0;
constexpr double kLeastGlowShare = 0.02;
constexpr double kGlowLightRad = RadFromDeg(4.0);
constexpr double kLeastFading = 1.4;

// From the same panoramas and an overcast one, cut at the brightest hundredth of the sky, and as 8
// bit pictures: suns have 89 % or more of what is level and radii up to 6.8 deg; bright clouds have
// up to half of it.
constexpr int kLeastPlateauPixels = 8;
constexpr double kLeastPlateauShare = 0.75;
constexpr double kLargestPlateauRad = RadFromDeg(8.0);

constexpr double kLargestAspect = 2.5;
constexpr std::size_t kLeastPixelsForAspect = 8;

class Spot {
 public:
  Spot(const GrayImage& luminance, int x, int y)
      : luminance_(luminance),
        size_{luminance.width, luminance.height},
        pixel_rad_(std::numbers::pi / luminance.height),
        start_(MapPixelDirection(x, y, size_)),
        peak_(luminance.At(x, y)) {
    for (const MapPixel& pixel : MapPixelsAround(start_, kSpotRad, size_)) {
      light_ += LatLongPixelSolidAngleSr(pixel.y, size_) * Value(pixel);
    }
  }

  const glm::dvec3& Start() const { return start_; }
  double Light() const { return light_; }

  // `sky_light`: of the map's upper half on a horizontal plane.
  std::optional<MapSun> AsSun(double sky_light) {
    around_ = MedianBetween(start_, kAroundFromRad, kAroundToRad);
    FindTop(around_ + 0.5 * (peak_ - around_));
    const double contrast = peak_ / std::max(around_, 1e-300);
    if (!(contrast >= kLeastFlatContrast) || !(sky_light > 0.0) || !IsRound()) return std::nullopt;
    const auto share = [&](double radius_rad) { return ExcessWithin(radius_rad) / sky_light; };
    if (radius_rad_ <= kLargestDiscRad + pixel_rad_) {
      if (contrast >= kLeastDiscContrast && share(RadFromDeg(2.0)) >= kLeastDiscShare) {
        return MapSun{centre_, MapSunKind::kDisc, pixel_rad_};
      }
      if (contrast <= kMostFlatContrast && IsTheOneFlatTop())
        return MapSun{centre_, MapSunKind::kFlatTop, pixel_rad_};
    }
    if (radius_rad_ >= kSmallestGlowRad && radius_rad_ <= kLargestGlowRad &&
        contrast >= kLeastGlowContrast && share(kGlowLightRad) >= kLeastGlowShare && Fades()) {
      return MapSun{centre_, MapSunKind::kGlow, 0.5 * radius_rad_ + pixel_rad_};
    }
    return std::nullopt;
  }

  // The same where the sun and much of its glare are cut at the map's largest value, which
  // `level_sr` of the map have.
  std::optional<MapSun> AsPlateau(double level_sr, double sky_light) {
    FindTop(peak_ * (1.0 - kOneLevel));
    const double area_sr = std::numbers::pi * radius_rad_ * radius_rad_;
    if (top_.size() < kLeastPlateauPixels || !(area_sr >= kLeastPlateauShare * level_sr) ||
        !(radius_rad_ > kLargestDiscRad + pixel_rad_) || !(radius_rad_ <= kLargestPlateauRad) ||
        !IsRound()) {
      return std::nullopt;
    }
    around_ = MedianBetween(centre_, 2.0 * radius_rad_, 4.0 * radius_rad_);
    if (!(peak_ >= kLeastFlatContrast * around_) || !(peak_ <= kMostFlatContrast * around_) ||
        !(ExcessWithin(radius_rad_) >= kLeastGlowShare * sky_light) || !Fades()) {
      return std::nullopt;
    }
    return MapSun{centre_, MapSunKind::kPlateau, 0.7 * radius_rad_ + pixel_rad_};
  }

 private:
  double Value(const MapPixel& pixel) const { return luminance_.At(pixel.x, pixel.y); }

  double MedianBetween(const glm::dvec3& centre, double from_rad, double to_rad) const {
    std::vector<double> values;
    for (const MapPixel& pixel : MapPixelsAround(centre, to_rad, size_)) {
      if (pixel.angle_rad > from_rad && pixel.y < size_.height / 2) values.push_back(Value(pixel));
    }
    return values.empty() ? 0.0 : UpperMedian(values);
  }

  // What hangs together around the start above a threshold: its radius, by area, and the middle of
  // the light there.
  void FindTop(double threshold) {
    const glm::ivec2 first = LatLongPixelFromDirection(start_, size_);
    Gray8Image seen(size_.width, size_.height, 0);
    std::vector<glm::ivec2> open{first};
    seen.At(first.x, first.y) = 1;
    glm::dvec3 sum(0.0);
    double area_sr = 0.0;
    const double least_cosine = std::cos(kAroundToRad);
    while (!open.empty()) {
      const glm::ivec2 at = open.back();
      open.pop_back();
      const glm::dvec3 direction = MapPixelDirection(at.x, at.y, size_);
      const double solid_angle_sr = LatLongPixelSolidAngleSr(at.y, size_);
      top_.push_back({direction, solid_angle_sr});
      area_sr += solid_angle_sr;
      sum += solid_angle_sr * (luminance_.At(at.x, at.y) - around_) * direction;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = (at.x + dx + size_.width) % size_.width;
          const int y = at.y + dy;
          if (y < 0 || y >= size_.height / 2 || seen.At(x, y) != 0) continue;
          if (!(luminance_.At(x, y) >= threshold) ||
              glm::dot(MapPixelDirection(x, y, size_), start_) < least_cosine) {
            continue;
          }
          seen.At(x, y) = 1;
          open.push_back({x, y});
        }
      }
    }
    radius_rad_ = std::sqrt(area_sr / std::numbers::pi);
    centre_ = glm::length(sum) > 0.0 ? glm::normalize(sum) : start_;
  }

  bool IsRound() const {
    if (top_.size() < kLeastPixelsForAspect) return true;
    const glm::dvec3 other =
        std::abs(centre_.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
    const glm::dvec3 right = glm::normalize(glm::cross(other, centre_));
    const glm::dvec3 up = glm::cross(centre_, right);
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    for (const TopPixel& pixel : top_) {
      const double x = glm::dot(pixel.direction, right);
      const double y = glm::dot(pixel.direction, up);
      xx += pixel.solid_angle_sr * x * x;
      xy += pixel.solid_angle_sr * x * y;
      yy += pixel.solid_angle_sr * y * y;
    }
    const double middle = 0.5 * (xx + yy);
    const double spread = std::hypot(0.5 * (xx - yy), xy);
    return middle + spread <= kLargestAspect * kLargestAspect * (middle - spread);
  }

  double ExcessWithin(double radius_rad) const {
    double sum = 0.0;
    for (const MapPixel& pixel : MapPixelsAround(centre_, radius_rad, size_)) {
      sum += LatLongPixelSolidAngleSr(pixel.y, size_) * std::max(Value(pixel) - around_, 0.0);
    }
    return sum;
  }

  bool IsTheOneFlatTop() const {
    const double least = peak_ * (1.0 - kOneLevel);
    const auto pixels = static_cast<std::ptrdiff_t>(luminance_.pixels.size() / 2);
    const auto level = std::count_if(luminance_.pixels.begin(),
                                     luminance_.pixels.begin() + pixels,
                                     [&](float value) { return value >= least; });
    std::ptrdiff_t here = 0;
    for (const MapPixel& pixel : MapPixelsAround(centre_, radius_rad_ + 2.0 * pixel_rad_, size_)) {
      here += Value(pixel) >= least ? 1 : 0;
    }
    return here >= kLeastFlatPixels && level - here <= here / 2;
  }

  bool Fades() const {
    const double near = MedianBetween(
        centre_, 1.3 * radius_rad_ + 1.5 * pixel_rad_, 2.0 * radius_rad_ + 3.0 * pixel_rad_);
    const double far = MedianBetween(
        centre_, 3.0 * radius_rad_ + 5.0 * pixel_rad_, 5.0 * radius_rad_ + 8.0 * pixel_rad_);
    return near >= kLeastFading * far;
  }

  struct TopPixel {
    glm::dvec3 direction;
    double solid_angle_sr;
  };

  const GrayImage& luminance_;
  LatLongSize size_;
  double pixel_rad_;
  glm::dvec3 start_;
  double peak_;
  double light_ = 0.0;
  double around_ = 0.0;
  std::vector<TopPixel> top_;
  double radius_rad_ = 0.0;
  glm::dvec3 centre_{0.0, 0.0, 1.0};
};

GrayImage LuminanceOf(const RgbImage& map) {
  GrayImage luminance(map.width, map.height);
  for (std::size_t i = 0; i < map.pixels.size(); ++i) {
    const glm::vec3& rgb = map.pixels[i];
    luminance.pixels[i] = (rgb.x + rgb.y + rgb.z) / 3.0f;
  }
  return luminance;
}

// The pixels of the upper half that have its largest value.
struct Level {
  std::vector<glm::ivec2> pixels;
  double solid_angle_sr = 0.0;
  float value = 0.0f;
};

Level LevelOf(const GrayImage& luminance) {
  const LatLongSize size{luminance.width, luminance.height};
  const std::ptrdiff_t upper = std::ptrdiff_t{size.height / 2} * size.width;
  Level level;
  level.value = *std::max_element(luminance.pixels.begin(), luminance.pixels.begin() + upper);
  for (int y = 0; y < size.height / 2; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (!(luminance.At(x, y) >= level.value * (1.0 - kOneLevel))) continue;
      level.pixels.emplace_back(x, y);
      level.solid_angle_sr += LatLongPixelSolidAngleSr(y, size);
    }
  }
  return level;
}

// Looks in the middle of what is level.
std::optional<MapSun> FindPlateau(const GrayImage& luminance, double sky_light) {
  const LatLongSize size{luminance.width, luminance.height};
  const Level level = LevelOf(luminance);
  const double largest_sr = std::numbers::pi * kLargestPlateauRad * kLargestPlateauRad;
  if (!(level.value > 0.0f) || level.solid_angle_sr * kLeastPlateauShare > largest_sr) {
    return std::nullopt;
  }
  glm::dvec3 middle(0.0);
  for (const glm::ivec2& at : level.pixels) {
    middle += LatLongPixelSolidAngleSr(at.y, size) * MapPixelDirection(at.x, at.y, size);
  }
  const auto farther = [&](const glm::ivec2& a, const glm::ivec2& b) {
    return glm::dot(MapPixelDirection(a.x, a.y, size), middle) <
           glm::dot(MapPixelDirection(b.x, b.y, size), middle);
  };
  const glm::ivec2 nearest = *std::max_element(level.pixels.begin(), level.pixels.end(), farther);
  return Spot(luminance, nearest.x, nearest.y).AsPlateau(level.solid_angle_sr, sky_light);
}

}  // namespace

std::optional<MapSun> FindMapSun(const RgbImage& map) {
  if (map.height < 2) return std::nullopt;
  const GrayImage luminance = LuminanceOf(map);
  const LatLongSize size{map.width, map.height};
  double sky_light = 0.0;
  for (int y = 0; y < size.height / 2; ++y) {
    const double weight = LatLongPixelSolidAngleSr(y, size) *
                          std::sin((0.5 - (y + 0.5) / size.height) * std::numbers::pi);
    for (int x = 0; x < size.width; ++x) sky_light += weight * luminance.At(x, y);
  }
  GrayImage left = luminance;
  std::optional<Spot> brightest;
  for (int k = 0; k < kSpots; ++k) {
    const auto top = std::max_element(
        left.pixels.begin(),
        left.pixels.begin() + static_cast<std::ptrdiff_t>(size.height / 2) * size.width);
    if (!(*top > 0.0f)) break;
    const auto index = static_cast<int>(top - left.pixels.begin());
    Spot spot(luminance, index % size.width, index / size.width);
    for (const MapPixel& pixel : MapPixelsAround(spot.Start(), kBetweenSpotsRad, size)) {
      left.At(pixel.x, pixel.y) = 0.0f;
    }
    if (!brightest || spot.Light() > brightest->Light()) brightest.emplace(std::move(spot));
  }
  std::optional<MapSun> sun;
  if (brightest) sun = brightest->AsSun(sky_light);
  return sun ? sun : FindPlateau(luminance, sky_light);
}

double ShareCutOff(const RgbImage& map) {
  if (map.height < 2) return 0.0;
  constexpr double kBrighter = 1.5;
  const GrayImage luminance = LuminanceOf(map);
  const Level level = LevelOf(luminance);
  const std::ptrdiff_t upper = std::ptrdiff_t{map.height / 2} * map.width;
  const double median = UpperMedian({luminance.pixels.begin(), luminance.pixels.begin() + upper});
  if (level.pixels.size() < kLeastPlateauPixels || !(level.value > kBrighter * median)) return 0.0;
  return level.solid_angle_sr / (2.0 * std::numbers::pi);
}

}  // namespace pleinair
