#include "calib/reconstruction/surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "calib/reconstruction/internal/surface_planes.h"
#include "calib/reconstruction/internal/wall_outline.h"
#include "scene/srgb.h"

namespace pleinair {
namespace {

constexpr double kAssumedAlbedo = 0.5;

// Light on a surface is not known: only its hue says something of the material.
glm::dvec3 AlbedoOf(const Reconstruction& world, const std::vector<std::uint32_t>& members) {
  glm::dvec3 sum(0.0);
  for (const std::uint32_t member : members) {
    const glm::dvec3& colour = world.points[member].colour_srgb;
    sum += glm::dvec3(LinearFromSrgb(colour.r), LinearFromSrgb(colour.g), LinearFromSrgb(colour.b));
  }
  const double mean = (sum.r + sum.g + sum.b) / 3.0;
  if (!(mean > 0.0)) return glm::dvec3(kAssumedAlbedo);
  return glm::clamp(sum * (kAssumedAlbedo / mean), glm::dvec3(0.05), glm::dvec3(0.9));
}

// Axes of a plane: `u` level, `v` up in it; u x v is the normal.
struct PlaneAxes {
  glm::dvec3 origin;
  glm::dvec3 u;
  glm::dvec3 v;

  glm::dvec2 Of(const glm::dvec3& p) const {
    return {glm::dot(u, p - origin), glm::dot(v, p - origin)};
  }
  glm::dvec3 At(const glm::dvec2& p) const { return origin + p.x * u + p.y * v; }
};

PlaneAxes AxesOf(const Plane& plane) {
  const glm::dvec3& n = plane.normal;
  const double level = std::hypot(n.x, n.y);
  const glm::dvec3 u =
      level > 1e-9 ? glm::dvec3(-n.y, n.x, 0.0) / level : glm::dvec3(1.0, 0.0, 0.0);
  return {plane.offset * n, u, glm::cross(n, u)};
}

// Lines of sight to points.
struct Sight {
  glm::dvec3 from;
  glm::dvec3 to;
};

std::vector<Sight> SightsOf(const Reconstruction& world) {
  std::vector<Sight> sights;
  for (std::size_t i = 0; i < world.pictures.size(); ++i) {
    const glm::dvec3 centre = world.pictures[i].Centre();
    for (const PointObservation& seen : VisiblePoints(world, i)) {
      sights.push_back({centre, world.points[seen.point].position});
    }
  }
  return sights;
}

glm::dvec3 MeanCamera(const Reconstruction& world) {
  glm::dvec3 mean(0.0);
  for (const ReconstructedPicture& picture : world.pictures) {
    mean += picture.Centre() / static_cast<double>(world.pictures.size());
  }
  return mean;
}

void TurnTowards(const glm::dvec3& eye, Plane& plane) {
  if (plane.DistanceOf(eye) < 0.0) plane = {-plane.normal, -plane.offset};
}

SiteSurface SurfaceOf(const Reconstruction& world, const SurfacePlane& found) {
  SiteSurface surface;
  surface.name = found.name;
  surface.plane = found.fit.plane;
  surface.albedo = AlbedoOf(world, found.fit.members);
  surface.points = found.fit.members.size();
  surface.rms_m = found.fit.rms;
  return surface;
}

// A wall that was found, along its axes, before it has an outline.
struct FoundWall {
  SurfacePlane plane;
  PlaneAxes axes;
  WallRectangle bounds;
};

// Without the few points at either end, which are the likeliest to be wrong.
std::pair<double, double> RangeOf(std::vector<double> values) {
  constexpr double kLeftOut = 0.005;
  std::sort(values.begin(), values.end());
  const auto skipped =
      static_cast<std::size_t>(std::floor(kLeftOut * static_cast<double>(values.size())));
  return {values[skipped], values[values.size() - 1 - skipped]};
}

FoundWall MeasureWall(const Reconstruction& world, SurfacePlane plane, double ground_m) {
  FoundWall wall{std::move(plane), {}, {}};
  wall.axes = AxesOf(wall.plane.fit.plane);
  std::vector<double> along;
  std::vector<double> up;
  for (const std::uint32_t member : wall.plane.fit.members) {
    const glm::dvec2 at = wall.axes.Of(world.points[member].position);
    along.push_back(at.x);
    up.push_back(at.y);
  }
  const auto [left, right] = RangeOf(along);
  wall.bounds = {{left, ground_m}, {right, RangeOf(up).second}};
  return wall;
}

// Ends of walls that nearly meet are moved to where they do.
void JoinCorners(std::vector<FoundWall>& walls, double tolerance_m) {
  constexpr double kNearOfWidth = 0.08;
  constexpr double kLeastSine = 0.35;  // Some 20 degrees.
  const std::vector<FoundWall> before = walls;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    FoundWall& wall = walls[i];
    const WallRectangle& own = before[i].bounds;
    const double near_m = std::max(6.0 * tolerance_m, kNearOfWidth * (own.upper.x - own.lower.x));
    for (std::size_t j = 0; j < walls.size(); ++j) {
      const Plane& other = before[j].plane.fit.plane;
      const double sine = glm::dot(other.normal, wall.axes.u);
      if (j == i || std::abs(sine) < kLeastSine) continue;
      const double meets = (other.offset - glm::dot(other.normal, wall.axes.origin)) / sine;
      const double there = before[j].axes.Of(wall.axes.At({meets, 0.0})).x;
      const WallRectangle& others = before[j].bounds;
      if (there < others.lower.x - near_m || there > others.upper.x + near_m) continue;
      if (std::abs(meets - own.lower.x) <= near_m) wall.bounds.lower.x = meets;
      if (std::abs(meets - own.upper.x) <= near_m) wall.bounds.upper.x = meets;
    }
  }
}

SiteSurface CloseWall(const Reconstruction& world,
                      const std::vector<Sight>& sights,
                      const FoundWall& wall,
                      double tolerance_m) {
  constexpr double kCellsAcross = 16.0;
  SiteSurface surface = SurfaceOf(world, wall.plane);
  std::vector<glm::dvec2> on_wall;
  for (const std::uint32_t member : wall.plane.fit.members) {
    on_wall.push_back(wall.axes.Of(world.points[member].position));
  }
  std::vector<glm::dvec2> through;
  for (const Sight& sight : sights) {
    const double before = surface.plane.DistanceOf(sight.from);
    const double behind = -surface.plane.DistanceOf(sight.to);
    if (!(before > 0.0 && behind > 3.0 * tolerance_m)) continue;
    through.push_back(
        wall.axes.Of(sight.from + (before / (before + behind)) * (sight.to - sight.from)));
  }
  const glm::dvec2 size = wall.bounds.upper - wall.bounds.lower;
  const double cell_m = std::max(4.0 * tolerance_m, std::max(size.x, size.y) / kCellsAcross);
  for (const WallRectangle& part : OutlineWall(wall.bounds, on_wall, through, cell_m)) {
    surface.polygons.push_back({wall.axes.At(part.lower),
                                wall.axes.At({part.upper.x, part.lower.y}),
                                wall.axes.At(part.upper),
                                wall.axes.At({part.lower.x, part.upper.y})});
  }
  return surface;
}

// Twice the signed area in the plane's axes.
double AreaOf(const std::vector<glm::dvec3>& polygon, const PlaneAxes& axes) {
  double area = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec2 a = axes.Of(polygon[i]);
    const glm::dvec2 b = axes.Of(polygon[(i + 1) % polygon.size()]);
    area += a.x * b.y - a.y * b.x;
  }
  return area;
}

double DiameterOf(const std::vector<glm::dvec3>& polygon) {
  double diameter = 0.0;
  for (const glm::dvec3& a : polygon) {
    for (const glm::dvec3& b : polygon) diameter = std::max(diameter, glm::distance(a, b));
  }
  return diameter;
}

// The marks of the picture with the most of them, on the plane; a rectangle about the points where
// no picture has three.
std::vector<glm::dvec3> MarkedOutline(const Reconstruction& world,
                                      const MarkedSurface& marked,
                                      const SurfacePlane& plane) {
  std::vector<std::size_t> counts(world.pictures.size(), 0);
  for (const SurfaceMark& mark : marked.marks) ++counts[mark.picture];
  const auto most = std::max_element(counts.begin(), counts.end());
  std::vector<glm::dvec3> outline;
  const PlaneAxes axes = AxesOf(plane.fit.plane);
  if (*most < 3) {
    std::vector<double> along;
    std::vector<double> up;
    for (const std::uint32_t member : plane.fit.members) {
      const glm::dvec2 at = axes.Of(world.points[member].position);
      along.push_back(at.x);
      up.push_back(at.y);
    }
    const auto [left, right] = RangeOf(along);
    const auto [low, high] = RangeOf(up);
    return {
        axes.At({left, low}), axes.At({right, low}), axes.At({right, high}), axes.At({left, high})};
  }
  const auto picture = static_cast<std::size_t>(most - counts.begin());
  const ReconstructedPicture& from = world.pictures[picture];
  const Lens lens(world.cameras[from.camera].intrinsics);
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(from.camera_from_model));
  const glm::dvec3 centre = from.Centre();
  for (const SurfaceMark& mark : marked.marks) {
    if (mark.picture != picture) continue;
    const auto ray = lens.DirectionFromPixel(mark.pixel);
    const glm::dvec3 direction = ray ? world_from_camera * *ray : glm::dvec3(0.0);
    const double along = glm::dot(plane.fit.plane.normal, direction);
    const double distance = -plane.fit.plane.DistanceOf(centre) / along;
    constexpr double kLeastSine = 0.005;
    if (!(std::abs(along) > kLeastSine && distance > 0.0)) {
      char text[160];
      std::snprintf(text,
                    sizeof(text),
                    ": expected marks that look onto its plane, found (%.1f, %.1f) in ",
                    mark.pixel.x,
                    mark.pixel.y);
      throw std::runtime_error("surface " + marked.name + text + from.name);
    }
    outline.push_back(centre + distance * direction);
  }
  if (AreaOf(outline, axes) < 0.0) std::reverse(outline.begin(), outline.end());
  return outline;
}

bool IsNear(const glm::dvec3& p, const std::vector<glm::dvec3>& polygon, double near_m) {
  glm::dvec3 lower(std::numeric_limits<double>::infinity());
  glm::dvec3 upper(-lower);
  for (const glm::dvec3& corner : polygon) {
    lower = glm::min(lower, corner);
    upper = glm::max(upper, corner);
  }
  for (int c = 0; c < 3; ++c) {
    if (p[c] < lower[c] - near_m || p[c] > upper[c] + near_m) return false;
  }
  return true;
}

// Corners that are nearly on the ground or on another surface are moved there in their own plane,
// onto two of these at most.
void JoinMarked(std::vector<SiteSurface>& surfaces) {
  constexpr double kNearOfDiameter = 0.05;
  constexpr double kLeastSine = 0.2;
  const std::vector<SiteSurface> before = surfaces;
  for (std::size_t i = 1; i < surfaces.size(); ++i) {
    const glm::dvec3& normal = surfaces[i].plane.normal;
    std::vector<glm::dvec3>& polygon = surfaces[i].polygons.front();
    const double near_m = kNearOfDiameter * DiameterOf(polygon);
    for (glm::dvec3& corner : polygon) {
      std::vector<std::pair<double, std::size_t>> near;
      for (std::size_t j = 0; j < before.size(); ++j) {
        const double off = std::abs(before[j].plane.DistanceOf(corner));
        const bool is_there =
            j == 0 ||
            IsNear(corner, before[j].polygons.front(), near_m);  // The ground is all over.
        if (j != i && off <= near_m && is_there) near.emplace_back(off, j);
      }
      std::sort(near.begin(), near.end());
      std::optional<glm::dvec3> line;
      for (const auto& candidate : near) {
        const Plane& other = before[candidate.second].plane;
        const glm::dvec3 across =
            line.value_or(other.normal - glm::dot(other.normal, normal) * normal);
        const double length = glm::length(across);
        if (length < kLeastSine) continue;
        const double sine = glm::dot(other.normal, across) / length;
        if (std::abs(sine) < kLeastSine) continue;
        corner -= (other.DistanceOf(corner) / sine) * (across / length);
        if (line) break;
        line = glm::normalize(glm::cross(normal, other.normal));
      }
    }
  }
}

std::vector<glm::dvec3> GroundPolygon(const Reconstruction& world,
                                      const std::vector<SiteSurface>& surfaces,
                                      double ground_m,
                                      double border_m) {
  glm::dvec3 lower(std::numeric_limits<double>::infinity());
  glm::dvec3 upper(-lower);
  const auto include = [&](const glm::dvec3& p) {
    lower = glm::min(lower, p);
    upper = glm::max(upper, p);
  };
  for (const ReconstructedPicture& picture : world.pictures) include(picture.Centre());
  for (const SiteSurface& surface : surfaces) {
    for (const auto& polygon : surface.polygons) {
      for (const glm::dvec3& corner : polygon) include(corner);
    }
  }
  lower -= border_m;
  upper += border_m;
  return {{lower.x, lower.y, ground_m},
          {upper.x, lower.y, ground_m},
          {upper.x, upper.y, ground_m},
          {lower.x, upper.y, ground_m}};
}

SurfacePlane AssumedGround(const Reconstruction& world,
                           const SurfaceOptions& options,
                           std::vector<std::string>& notes) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const ReconstructedPicture& picture : world.pictures) {
    lowest = std::min(lowest, picture.Centre().z);
  }
  char text[160];
  std::snprintf(text,
                sizeof(text),
                "no points show the ground: it is assumed %.2f m below the lowest camera "
                "(--camera-height)",
                options.camera_height_m);
  notes.emplace_back(text);
  SurfacePlane ground{"ground", {}};
  ground.fit.plane.offset = lowest - options.camera_height_m;
  return ground;
}

}  // namespace

SiteSurfaces FitSurfaces(const Reconstruction& world,
                         std::span<const MarkedSurface> marked,
                         const SurfaceOptions& options) {
  if (!(options.tolerance_m > 0.0) || !(options.camera_height_m >= 0.0) ||
      !(options.border_m >= 0.0)) {
    throw std::invalid_argument("SurfaceOptions: expected tolerance_m above 0, others from 0 on");
  }
  SiteSurfaces result;
  std::optional<SurfacePlane> ground;
  std::vector<SurfacePlane> planes;
  std::vector<MarkedSurface> outlines;
  for (const MarkedSurface& surface : marked) {
    if (surface.name == "ground") {
      ground = FitMarked(world, surface, options.tolerance_m);
    } else {
      planes.push_back(FitMarked(world, surface, options.tolerance_m));
      outlines.push_back(surface);
    }
  }
  if (!ground) {
    if (auto found = FindGround(world, options.tolerance_m)) ground = {"ground", std::move(*found)};
  }
  if (!ground) ground = AssumedGround(world, options, result.notes);
  const double ground_m = ground->fit.plane.offset;
  if (outlines.empty()) planes = FindWalls(world, ground_m, options);
  if (planes.empty() && ground->fit.members.empty()) {
    throw std::runtime_error(
        "expected points of ground or walls, found no plane that enough of the " +
        std::to_string(world.points.size()) + " points are near to (--tolerance, --marks)");
  }
  if (!outlines.empty()) AlignDirections(world, options, planes);

  const glm::dvec3 eye = MeanCamera(world);
  for (SurfacePlane& plane : planes) TurnTowards(eye, plane.fit.plane);
  result.surfaces.push_back(SurfaceOf(world, *ground));
  if (ground->fit.members.empty()) result.surfaces.front().albedo = glm::dvec3(kAssumedAlbedo);
  if (!outlines.empty()) {
    for (std::size_t i = 0; i < planes.size(); ++i) {
      result.surfaces.push_back(SurfaceOf(world, planes[i]));
      result.surfaces.back().polygons.push_back(MarkedOutline(world, outlines[i], planes[i]));
    }
    JoinMarked(result.surfaces);
  } else {
    std::vector<FoundWall> walls;
    walls.reserve(planes.size());
    for (const SurfacePlane& plane : planes) walls.push_back(MeasureWall(world, plane, ground_m));
    JoinCorners(walls, options.tolerance_m);
    const std::vector<Sight> sights = SightsOf(world);
    for (const FoundWall& wall : walls) {
      SiteSurface closed = CloseWall(world, sights, wall, options.tolerance_m);
      // Railings and rows of columns are mostly seen through.
      constexpr double kLeastWall = 0.25;
      const glm::dvec2 size = wall.bounds.upper - wall.bounds.lower;
      double area = 0.0;
      for (const auto& polygon : closed.polygons) area += 0.5 * AreaOf(polygon, wall.axes);
      if (area < kLeastWall * size.x * size.y) continue;
      closed.name = "wall-";
      closed.name += std::to_string(result.surfaces.size());
      result.surfaces.push_back(std::move(closed));
    }
  }
  result.surfaces.front().polygons = {
      GroundPolygon(world, result.surfaces, ground_m, options.border_m)};
  return result;
}

std::string ObjText(std::span<const SiteSurface> surfaces, const std::string& material_library) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(4)
       << "# Ground and walls fitted to a reconstruction: metres, +X east, +Y north, +Z up\n"
       << "mtllib " << material_library << '\n';
  std::size_t next = 1;
  for (const SiteSurface& surface : surfaces) {
    text << "g " << surface.name << "\nusemtl " << surface.name << '\n';
    for (const std::vector<glm::dvec3>& polygon : surface.polygons) {
      for (const glm::dvec3& p : polygon) {
        text << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
      }
      text << 'f';
      for (std::size_t i = 0; i < polygon.size(); ++i) text << ' ' << next++;
      text << '\n';
    }
  }
  return text.str();
}

std::string MtlText(std::span<const SiteSurface> surfaces) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3)
       << "# Kd is a guess: the hue of the points' colours, with a mean of 0.5\n";
  for (const SiteSurface& surface : surfaces) {
    const glm::dvec3& kd = surface.albedo;
    text << "newmtl " << surface.name << "\nKd " << kd.r << ' ' << kd.g << ' ' << kd.b
         << "\nKs 0 0 0\n";
  }
  return text.str();
}

}  // namespace pleinair
