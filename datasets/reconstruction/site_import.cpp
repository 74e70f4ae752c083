#include "datasets/reconstruction/site_import.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "datasets/camera/live_frame_source.h"
#include "datasets/reconstruction/internal/photograph.h"
#include "datasets/reconstruction/internal/resampled_picture.h"
#include "datasets/reconstruction/reconstruction_file.h"
#include "datasets/sequence.h"
#include "scene/image_io.h"
#include "scene/upper_median.h"
#include "scene/whole_file.h"
#include "sunmodel/angles.h"
#include "sunmodel/local_frame.h"

namespace pleinair {
namespace {

namespace fs = std::filesystem;

constexpr double kReceiverSigmaM = 5.0;  // For a telephone under open sky, where it states none.
constexpr double kCompassSigmaRad = RadFromDeg(10.0);
constexpr int kJpegQuality = 95;

std::size_t PictureNamed(const Reconstruction& reconstruction, const std::string& name) {
  for (std::size_t i = 0; i < reconstruction.pictures.size(); ++i) {
    if (reconstruction.pictures[i].name == name) return i;
  }
  std::string known;
  for (const ReconstructedPicture& picture : reconstruction.pictures) {
    if (known.size() > 200) break;
    known += (known.empty() ? "" : ", ") + picture.name;
  }
  throw std::runtime_error("picture " + name + ": expected one of the reconstruction's: " + known);
}

glm::dvec3 PointWithId(const Reconstruction& reconstruction, std::int64_t id) {
  for (const ReconstructedPoint& point : reconstruction.points) {
    if (point.id == id) return point.position;
  }
  throw std::runtime_error(fmt::format("point {}: expected a point of the reconstruction", id));
}

// The point that the picture shows nearest to a pick.
glm::dvec3 PointAtPick(const Reconstruction& reconstruction,
                       std::size_t picture,
                       const glm::dvec2& pixel) {
  constexpr double kFarthestOfWidth = 0.01;
  double nearest_px = std::numeric_limits<double>::infinity();
  glm::dvec3 position(0.0);
  for (const PointObservation& seen : VisiblePoints(reconstruction, picture)) {
    const double off_px = glm::distance(seen.pixel, pixel);
    if (off_px >= nearest_px) continue;
    nearest_px = off_px;
    position = reconstruction.points[seen.point].position;
  }
  const ReconstructedPicture& in = reconstruction.pictures[picture];
  const int width_px = reconstruction.cameras[in.camera].intrinsics.width_px;
  if (!(nearest_px <= kFarthestOfWidth * width_px)) {
    throw std::runtime_error(
        fmt::format("--between: expected a point of the reconstruction within {:.0f} px of "
                    "({:.0f}, {:.0f}) in {}, found the nearest one {:.0f} px away",
                    kFarthestOfWidth * width_px,
                    pixel.x,
                    pixel.y,
                    in.name,
                    nearest_px));
  }
  return position;
}

double MetresPerUnit(const Reconstruction& reconstruction, const KnownLength& known) {
  glm::dvec3 first;
  glm::dvec3 second;
  if (const auto* ids = std::get_if<PointPair>(&known.between)) {
    first = PointWithId(reconstruction, ids->first);
    second = PointWithId(reconstruction, ids->second);
  } else {
    const auto& picks = std::get<PickPair>(known.between);
    const std::size_t picture = PictureNamed(reconstruction, picks.picture);
    first = PointAtPick(reconstruction, picture, picks.first_px);
    second = PointAtPick(reconstruction, picture, picks.second_px);
  }
  const double units = glm::distance(first, second);
  if (!(units > 0.0)) throw std::runtime_error("--between: expected two points, found one twice");
  return known.length_m / units;
}

double MedianDistance(const Reconstruction& reconstruction) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < reconstruction.pictures.size(); ++i) {
    const glm::dvec3 centre = reconstruction.pictures[i].Centre();
    for (const PointObservation& seen : VisiblePoints(reconstruction, i)) {
      distances.push_back(glm::distance(centre, reconstruction.points[seen.point].position));
    }
  }
  if (distances.empty()) {
    throw std::runtime_error("expected pictures that show points of the reconstruction");
  }
  return UpperMedianInPlace(distances);
}

Gray8Image LumaOf(const Rgb8Image& picture) {
  Gray8Image grey(picture.width, picture.height);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const glm::ivec3 code(picture.pixels[i]);
    grey.pixels[i] = static_cast<std::uint8_t>((2 * code.r + 5 * code.g + code.b) / 8);
  }
  return grey;
}

glm::dmat3 TurnAboutUp(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {{c, s, 0.0}, {-s, c, 0.0}, {0.0, 0.0, 1.0}};
}

// Turns `up` to +Z.
glm::dmat3 LevelFrom(const glm::dvec3& up) {
  const glm::dvec3 x = LevelBelow(up, 1.0).front().direction;
  return glm::transpose(glm::dmat3(x, glm::cross(up, x), up));
}

class Importer {
 public:
  explicit Importer(const SiteImportOptions& options)
      : options_(options), made_(ReadReconstruction(options.reconstruction)) {
    report_.notes = made_.notes;
    report_.pictures = made_.pictures.size();
    report_.points = made_.points.size();
  }

  SiteImportReport Import() {
    RequireEmptyOut();
    ResolveMarks();
    FindPhotographs();
    ChooseFrames();
    FindUp();
    PlaceOnEarth();
    FitAndGround();
    WriteWholeFolder(options_.out, [&](const fs::path& folder) { Write(folder); });
    return std::move(report_);
  }

 private:
  void RequireEmptyOut() const {
    std::error_code error;
    if (!fs::exists(options_.out, error)) return;
    if (!fs::is_directory(options_.out, error) || !fs::is_empty(options_.out, error)) {
      throw std::runtime_error(options_.out.string() +
                               ": expected an empty folder, or none, to write the site to");
    }
  }

  void ResolveMarks() {
    for (const PictureMark& mark : options_.marks) {
      const auto known =
          std::find_if(marked_.begin(), marked_.end(), [&](const MarkedSurface& surface) {
            return surface.name == mark.surface;
          });
      MarkedSurface& surface =
          known != marked_.end() ? *known : marked_.emplace_back(MarkedSurface{mark.surface, {}});
      surface.marks.push_back({PictureNamed(made_, mark.picture), mark.pixel});
    }
    for (const StatedHeading& heading : options_.headings) PictureNamed(made_, heading.picture);
  }

  void FindPhotographs() {
    std::size_t missing = 0;
    for (const ReconstructedPicture& picture : made_.pictures) {
      photographs_.push_back(FindPhotograph(options_.photos, picture.name, options_.utc_offset));
      if (!photographs_.back()) {
        ++missing;
        continue;
      }
      const auto stated = options_.times.find(picture.name);
      if (stated != options_.times.end()) photographs_.back()->time = stated->second;
    }
    if (missing == made_.pictures.size()) {
      throw std::runtime_error(
          fmt::format("{}: expected the reconstruction's photographs, such as "
                      "{}, found none of them",
                      options_.photos.string(),
                      made_.pictures.front().name));
    }
    if (missing > 0) {
      report_.notes.push_back(fmt::format("{} of {} photographs are not in {}",
                                          missing,
                                          made_.pictures.size(),
                                          options_.photos.string()));
    }
    for (const auto& photograph : photographs_) {
      orientations_.push_back(photograph ? photograph->place.orientation.value_or(1) : 1);
    }
  }

  std::string WhyUntimed() const {
    std::string why = "their EXIF data state no time";
    if (!options_.utc_offset) why += " with an offset";
    if (!options_.times.empty()) return why + ", and --times does not name them";
    return why + (options_.utc_offset ? " (--times)" : " (--utc-offset, --times)");
  }

  void ChooseFrames() {
    std::vector<std::size_t> counts(made_.cameras.size(), 0);
    for (std::size_t i = 0; i < made_.pictures.size(); ++i) {
      if (photographs_[i]) ++counts[made_.pictures[i].camera];
    }
    camera_ =
        static_cast<std::size_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
    if (!options_.camera.empty()) {
      const auto named = std::find_if(
          made_.cameras.begin(), made_.cameras.end(), [&](const ReconstructedCamera& camera) {
            return camera.name == options_.camera;
          });
      if (named == made_.cameras.end()) {
        throw std::runtime_error("--camera " + options_.camera +
                                 ": expected a camera of the reconstruction, such as " +
                                 made_.cameras.front().name);
      }
      camera_ = static_cast<std::size_t>(named - made_.cameras.begin());
    }
    std::size_t others = 0;
    for (std::size_t i = 0; i < made_.pictures.size(); ++i) {
      if (!photographs_[i]) continue;
      if (!SeesAlike(made_.cameras[made_.pictures[i].camera].intrinsics,
                     made_.cameras[camera_].intrinsics)) {
        ++others;
      } else if (photographs_[i]->time) {
        frames_.push_back(i);
      } else {
        untimed_.push_back(made_.pictures[i].name);
      }
    }
    if (frames_.empty()) {
      throw std::runtime_error(
          (options_.photos / (untimed_.empty() ? "" : untimed_.front())).string() +
          ": expected photographs of camera " + made_.cameras[camera_].name +
          " whose UTC is known, found none: " + WhyUntimed());
    }
    if (others > 0) {
      report_.notes.push_back(fmt::format(
          "{} photographs of cameras with another field of view are no frames: a sequence has one "
          "camera (--camera)",
          others));
    }
    if (!untimed_.empty()) {
      report_.notes.push_back(fmt::format("{} photographs are no frames, as {}: {}",
                                          untimed_.size(),
                                          untimed_.front(),
                                          WhyUntimed()));
    }
    std::stable_sort(frames_.begin(), frames_.end(), [&](std::size_t a, std::size_t b) {
      return *photographs_[a]->time < *photographs_[b]->time;
    });
  }

  void FindUp() {
    glm::dvec3 sense = UpInPictures(made_, orientations_);
    std::vector<LevelDirection> evidence = LevelOfCameras(made_, orientations_);
    if (made_.enu_at) {
      constexpr double kAlignedSigmaRad = RadFromDeg(5.0);
      sense = {0.0, 0.0, 1.0};
      for (const LevelDirection& level : LevelBelow(sense, kAlignedSigmaRad)) {
        evidence.push_back(level);
      }
    }
    report_.up = EstimateUp(evidence, sense);
    // The tilt of cameras is not known well: they look up at houses.
    const std::vector<PictureEdge> edges = EdgesOfPhotographs();
    const std::vector<PlaneNormal> planes =
        FindPlaneNormals(made_, kToleranceOfDistance * MedianDistance(made_));
    const glm::dvec3 right = RightInPictures(made_, orientations_);
    if (const auto found = SearchUp(edges, planes, report_.up.up, right)) {
      for (const LevelDirection& level : LevelOfEdges(edges, *found, photographs_.size())) {
        evidence.push_back(level);
      }
      for (const LevelDirection& level : LevelOfPlanes(planes, *found)) evidence.push_back(level);
      report_.up = EstimateUp(evidence, *found);
    }
    wall_direction_ = LevelEdgeDirection(edges, report_.up.up);
    Move({1.0, LevelFrom(report_.up.up), glm::dvec3(0.0)});
  }

  std::vector<PictureEdge> EdgesOfPhotographs() const {
    std::vector<PictureEdge> edges;
    for (std::size_t i = 0; i < made_.pictures.size(); ++i) {
      if (!photographs_[i]) continue;
      const Rgb8Image picture = ReadDisplayImage(photographs_[i]->file);
      const CameraIntrinsics intrinsics = IntrinsicsOf(i, picture.width, picture.height);
      for (const PictureEdge& edge :
           FindEdges(LumaOf(picture), intrinsics, made_.pictures[i].camera_from_model)) {
        edges.push_back(edge);
      }
    }
    return edges;
  }

  // The reconstruction, and what is known of its directions.
  void Move(const Similarity& target_from_model) {
    Transform(target_from_model, made_);
    if (wall_direction_) wall_direction_ = target_from_model.rotation * *wall_direction_;
  }

  // The camera's with the photograph's size.
  CameraIntrinsics IntrinsicsOf(std::size_t picture, int width_px, int height_px) const {
    try {
      return ScaledTo(
          made_.cameras[made_.pictures[picture].camera].intrinsics, width_px, height_px);
    } catch (const std::runtime_error&) {
      const CameraIntrinsics& camera = made_.cameras[made_.pictures[picture].camera].intrinsics;
      const bool is_turned =
          std::int64_t{width_px} * camera.width_px == std::int64_t{height_px} * camera.height_px;
      throw std::runtime_error(fmt::format(
          "{}: expected the shape of the reconstruction's camera, {}x{}, found {}x{} pixels{}",
          photographs_[picture]->file.string(),
          camera.width_px,
          camera.height_px,
          width_px,
          height_px,
          is_turned ? ": one of the two is turned by its EXIF orientation" : ""));
    }
  }

  // The chosen camera with the size of frames: that of its first photograph, reduced.
  CameraIntrinsics FrameCamera() const {
    std::size_t first = frames_.front();
    for (const std::size_t picture : frames_) {
      if (made_.pictures[picture].camera != camera_) continue;
      first = picture;
      break;
    }
    const Rgb8Image stored = ReadDisplayImage(photographs_[first]->file);
    const int longest = std::max(stored.width, stored.height);
    const double shrink = options_.longest_side_px > 0 && longest > options_.longest_side_px
                              ? static_cast<double>(options_.longest_side_px) / longest
                              : 1.0;
    const CameraIntrinsics camera = IntrinsicsOf(first, stored.width, stored.height);
    return ScaledTo(camera,
                    std::max(1, static_cast<int>(std::lround(stored.width * shrink))),
                    std::max(1, static_cast<int>(std::lround(stored.height * shrink))));
  }

  // Where receivers' positions are counted from.
  Site Reference() const {
    if (options_.site) return *options_.site;
    std::vector<double> latitudes;
    std::vector<double> longitudes;
    std::vector<double> altitudes;
    for (const auto& photograph : photographs_) {
      if (!photograph || !photograph->place.latitude_deg) continue;
      latitudes.push_back(*photograph->place.latitude_deg);
      longitudes.push_back(*photograph->place.longitude_deg);
      if (photograph->place.altitude_m) altitudes.push_back(*photograph->place.altitude_m);
    }
    if (latitudes.empty()) {
      if (made_.enu_at) return *made_.enu_at;
      throw std::runtime_error(
          "--site: expected LAT,LON[,H], as no photograph's EXIF data state a position");
    }
    const auto median = [](std::vector<double>& values) {
      std::sort(values.begin(), values.end());
      return values.empty() ? 0.0 : values[values.size() / 2];
    };
    return {RadFromDeg(median(latitudes)), RadFromDeg(median(longitudes)), median(altitudes)};
  }

  std::vector<GeoReading> Readings(const Site& reference) const {
    std::vector<GeoReading> readings;
    bool any_position = false;
    for (std::size_t i = 0; i < made_.pictures.size(); ++i) {
      const ReconstructedPicture& picture = made_.pictures[i];
      GeoReading reading;
      reading.centre = picture.Centre();
      reading.forward = glm::transpose(glm::dmat3(picture.camera_from_model))[2];
      reading.heading_sigma_rad = kCompassSigmaRad;
      if (photographs_[i]) {
        const ExifPlace& place = photographs_[i]->place;
        if (place.latitude_deg) {
          any_position = true;
          reading.position_enu_m = EnuOf({RadFromDeg(*place.latitude_deg),
                                          RadFromDeg(*place.longitude_deg),
                                          reference.height_m},
                                         reference);
          reading.position_sigma_m = place.position_sigma_m.value_or(kReceiverSigmaM);
        }
        if (place.heading_deg) reading.heading_rad = RadFromDeg(*place.heading_deg);
      }
      readings.push_back(reading);
      for (const StatedHeading& stated : options_.headings) {
        if (stated.picture != picture.name) continue;
        GeoReading& own = readings.back();
        own.heading_rad = stated.azimuth_rad;
        own.heading_sigma_rad = stated.sigma_rad;
      }
    }
    // The reconstruction's own frame, where that is all there is.
    if (!any_position && made_.enu_at && !options_.site) {
      for (GeoReading& reading : readings) reading.position_enu_m = reading.centre;
    }
    return readings;
  }

  void PlaceOnEarth() {
    const Site reference = Reference();
    std::optional<double> scale;
    if (options_.length) scale = MetresPerUnit(made_, *options_.length);
    report_.earth = AlignToEarth(Readings(reference), scale);
    const GeoAlignment& earth = report_.earth;
    if (!std::isfinite(earth.scale_sigma)) {
      throw std::runtime_error(
          "--length: expected a known length between two points, as the photographs' positions do "
          "not determine the scale");
    }
    report_.metres_per_unit = earth.scale;
    Move({earth.scale, TurnAboutUp(earth.turn_rad), earth.translation});
    glm::dvec3 mean(0.0);
    for (const ReconstructedPicture& picture : made_.pictures) {
      mean += picture.Centre() / static_cast<double>(made_.pictures.size());
    }
    const glm::dvec3 origin(mean.x, mean.y, 0.0);
    report_.site = earth.has_position ? PlaceAt(origin, reference) : reference;
    report_.site.height_m = reference.height_m;
    Move({1.0, glm::dmat3(1.0), -origin});
  }

  void FitAndGround() {
    SurfaceOptions surface_options = options_.surfaces;
    surface_options.tolerance_m = options_.tolerance_m > 0.0
                                      ? options_.tolerance_m
                                      : kToleranceOfDistance * MedianDistance(made_);
    report_.tolerance_m = surface_options.tolerance_m;
    surface_options.wall_direction = wall_direction_;
    SiteSurfaces fitted = FitSurfaces(made_, marked_, surface_options);
    report_.notes.insert(report_.notes.end(), fitted.notes.begin(), fitted.notes.end());
    report_.surfaces = std::move(fitted.surfaces);
    const glm::dvec3 down(0.0, 0.0, -report_.surfaces.front().plane.offset);
    Move({1.0, glm::dmat3(1.0), down});
    for (SiteSurface& surface : report_.surfaces) {
      surface.plane.offset += glm::dot(surface.plane.normal, down);
      for (auto& polygon : surface.polygons) {
        for (glm::dvec3& corner : polygon) corner += down;
      }
    }
  }

  // A photograph as the picture of a frame of `sequence`.
  fs::path WritePicture(std::size_t picture, std::size_t index, const Sequence& sequence) const {
    const fs::path& file = photographs_[picture]->file;
    const Rgb8Image stored = ReadDisplayImage(file);
    const CameraIntrinsics own = IntrinsicsOf(picture, stored.width, stored.height);
    const bool is_same = own == sequence.intrinsics;
    fs::path name = fs::path("frames_ldr") /
                    fmt::format("{:06}{}", index, is_same ? file.extension().string() : ".jpg");
    if (is_same) {
      WriteWholeFile(sequence.folder / name, ReadWholeFile(file));
    } else {
      WriteJpeg(sequence.folder / name, SeenBy(sequence.intrinsics, stored, own), kJpegQuality);
    }
    return name;
  }

  void Write(const fs::path& folder) {
    fs::create_directories(folder / "frames_ldr");
    WriteWholeText(folder / "scene.obj", ObjText(report_.surfaces, "scene.mtl"));
    WriteWholeText(folder / "scene.mtl", MtlText(report_.surfaces));
    Sequence sequence;
    sequence.folder = folder;
    sequence.site = report_.site;
    sequence.north_stddev_rad = report_.earth.turn_sigma_rad;
    sequence.scene_mesh = "scene.obj";
    sequence.albedos_assumed = true;
    // A surface without points may not be what the pictures show there.
    for (const SiteSurface& surface : report_.surfaces) {
      if (surface.points > 0) sequence.diffuse_regions.push_back(surface.name);
    }
    sequence.intrinsics = FrameCamera();
    for (std::size_t index = 0; index < frames_.size(); ++index) {
      const std::size_t picture = frames_[index];
      FrameEntry frame;
      frame.image_ldr = WritePicture(picture, index, sequence);
      frame.time = *photographs_[picture]->time;
      const ExifExposure& exposure = photographs_[picture]->exposure;
      if (exposure.exposure_s && exposure.iso && exposure.f_number) {
        frame.exposure_s = exposure.exposure_s;
        frame.iso = exposure.iso;
        frame.f_number = exposure.f_number;
      }
      frame.camera_from_world = made_.pictures[picture].camera_from_model;
      sequence.frames.push_back(std::move(frame));
    }
    sequence.camera_from_world = sequence.frames.front().camera_from_world;
    report_.frames = sequence.frames.size();
    WriteSequence(sequence, folder);
  }

  static constexpr double kToleranceOfDistance = 0.005;

  const SiteImportOptions& options_;
  Reconstruction made_;  // Moved to the world step by step.
  SiteImportReport report_;
  std::vector<MarkedSurface> marked_;
  std::vector<std::optional<Photograph>> photographs_;  // A picture each.
  std::vector<int> orientations_;
  std::optional<glm::dvec3> wall_direction_;  // Level; that of the photographs' level edges.
  std::size_t camera_ = 0;
  std::vector<std::size_t> frames_;  // Pictures, in the order of time.
  std::vector<std::string> untimed_;
};

}  // namespace

SiteImportReport ImportSite(const SiteImportOptions& options) { return Importer(options).Import(); }

}  // namespace pleinair
