// sequence.json with every key missing, of a wrong type, out of range; unknown keys; hostile JSON;
// paths that leave the folder.
#include <algorithm>
#include <random>
#include <set>
#include <sstream>

#include "datasets/sequence.h"
#include "tests/datasets/sequence_fixture.h"

namespace pleinair::sequence_hard_cases_test {
namespace {

using SequenceHardCases = SequenceFolder;
using Pointer = nlohmann::json::json_pointer;

// "/frames/0/iso" -> "frames[0].iso", as refusals write it.
std::string Written(const Pointer& pointer) {
  std::string text;
  std::stringstream parts(pointer.to_string());
  std::string part;
  std::getline(parts, part, '/');
  while (std::getline(parts, part, '/')) {
    const bool index = part.find_first_not_of("0123456789") == std::string::npos;
    text += index ? "[" + part + "]" : (text.empty() ? "" : ".") + part;
  }
  return text;
}

// Every value of the document, the root left out.
void Collect(const nlohmann::json& value, const Pointer& at, std::vector<Pointer>& found) {
  if (!at.empty()) found.push_back(at);
  if (value.is_object()) {
    for (const auto& [key, child] : value.items()) Collect(child, at / key, found);
  }
  if (value.is_array()) {
    for (std::size_t i = 0; i < value.size(); ++i) Collect(value[i], at / i, found);
  }
}

std::vector<Pointer> AllOf(const nlohmann::json& document) {
  std::vector<Pointer> found;
  Collect(document, Pointer(), found);
  return found;
}

// Keys that may hold anything: `name`, and those that begin with note, formula or world.
bool IsFree(const Pointer& pointer) {
  const std::string& key = pointer.back();
  return key == "name" || key.starts_with("note") || key.starts_with("formula") || key == "world";
}

enum class Kind { kNull, kBoolean, kNumber, kText, kList, kObject };

Kind KindOf(const nlohmann::json& value) {
  if (value.is_null()) return Kind::kNull;
  if (value.is_boolean()) return Kind::kBoolean;
  if (value.is_number()) return Kind::kNumber;
  if (value.is_string()) return Kind::kText;
  return value.is_array() ? Kind::kList : Kind::kObject;
}

TEST_F(SequenceHardCases, NameTheFileAndTheKeyOfEveryWrongType) {
  const nlohmann::json document = Everything();
  const nlohmann::json wrong = nlohmann::json::parse(R"([null, true, 3, "zz", [], {}])");
  int tried = 0;
  for (const Pointer& pointer : AllOf(document)) {
    for (const nlohmann::json& value : wrong) {
      if (KindOf(value) == KindOf(document[pointer])) continue;
      nlohmann::json broken = document;
      broken[pointer] = value;
      const std::string refusal = Refusal(broken);
      ++tried;
      if (IsFree(pointer)) {
        EXPECT_EQ(refusal, "accepted") << pointer.to_string() << " = " << value;
        continue;
      }
      EXPECT_NE(refusal.find((folder_ / "sequence.json").string() + ": " + Written(pointer)),
                std::string::npos)
          << pointer.to_string() << " = " << value << ": " << refusal;
    }
  }
  EXPECT_GT(tried, 600);
}

TEST_F(SequenceHardCases, NameEveryMissingKeyThatIsRequired) {
  // What has a default, or something to stand in for it (a pose of the frames' own is not there
  // for frame 1, a fish-eye image needs `fisheye`). List entries are the next test's.
  const std::set<std::string> optional{"name",
                                       "world",
                                       "note_source",
                                       "site",  // The fish-eye camera sees the sun.
                                       "camera.distortion",
                                       "camera.distortion_model",
                                       "camera.pixel_centers",
                                       "site.north_uncertain_deg",
                                       "weather",
                                       "radiometry",
                                       "radiometry.frames",
                                       "radiometry.frames_ldr",
                                       "scene.albedos_known",
                                       "scene.albedos_assumed",
                                       "windows",
                                       "windows[0].name",
                                       "diffuse_regions",
                                       "diffuse_mask",
                                       "environment",
                                       "environment.image",  // Its sun may stand alone.
                                       "environment.sun_direction_enu",
                                       "environment.mapping",
                                       "environment.mapping.type",
                                       "environment.mapping.up",
                                       "environment.mapping.center",
                                       "environment.mapping.right",
                                       "environment.mapping.formula",
                                       "fisheye.up",
                                       "fisheye.image_up",
                                       "fisheye.image_right",
                                       "fisheye.position_m",
                                       "fisheye.calibration",
                                       "virtual_object",
                                       "frames[0].image",
                                       "frames[0].image_ldr",
                                       "frames[0].fisheye",
                                       "frames[0].exposure",
                                       "frames[0].exposure_s",
                                       "frames[0].iso",
                                       "frames[0].f_number",
                                       "frames[0].camera_from_world",
                                       "frames[0].sun_direction_enu",
                                       "frames[0].weather",
                                       "frames[0].sample_polygons"};
  const nlohmann::json document = Everything();
  int required = 0;
  for (const Pointer& pointer : AllOf(document)) {
    if (document[pointer.parent_pointer()].is_array()) continue;
    nlohmann::json broken = document;
    broken[pointer.parent_pointer()].erase(pointer.back());
    const std::string refusal = Refusal(broken);
    const std::string key = Written(pointer);
    if (optional.count(key) != 0) {
      EXPECT_EQ(refusal, "accepted") << key;
      continue;
    }
    ++required;
    // The pose is missed where it is needed; frame 1 has one image only.
    const std::string named = key == "camera.camera_from_world" ? "frames[1].camera_from_world"
                              : key == "frames[1].image_ldr"    ? "frames[1]"
                              : key == "fisheye"                ? "frames[0].fisheye"
                                                                : key;
    EXPECT_NE(refusal.find(": " + named + ": expected"), std::string::npos) << key << refusal;
  }
  EXPECT_EQ(required, 33);
}

TEST_F(SequenceHardCases, RefuseShortAndLongLists) {
  const nlohmann::json document = Everything();
  for (const char* fixed : {"/camera/distortion",
                            "/camera/camera_from_world",
                            "/camera/camera_from_world/2",
                            "/windows/0/polygon_world_m/1",
                            "/environment/position_m",
                            "/environment/sun_direction_enu",
                            "/fisheye/position_m",
                            "/virtual_object/world_from_object/0",
                            "/frames/0/sample_polygons/0/polygon_px/0"}) {
    const Pointer pointer(fixed);
    nlohmann::json broken = document;
    broken[pointer].erase(broken[pointer].size() - 1);
    EXPECT_NE(Refusal(broken).find(Written(pointer) + ": expected a list of"), std::string::npos);
    broken = document;
    broken[pointer].push_back(broken[pointer].back());
    EXPECT_NE(Refusal(broken).find(Written(pointer) + ": expected a list of"), std::string::npos);
  }
  for (const char* at_least :
       {"/windows/0/polygon_world_m", "/frames/0/sample_polygons/0/polygon_px", "/frames"}) {
    const Pointer pointer(at_least);
    nlohmann::json broken = document;
    while (broken[pointer].size() > 2) broken[pointer].erase(0);
    if (pointer.back() == "frames") broken[pointer] = nlohmann::json::array();
    EXPECT_NE(Refusal(broken).find(Written(pointer) + ": expected a list of at least"),
              std::string::npos);
  }
}

TEST_F(SequenceHardCases, NameEveryValueOutOfRange) {
  const nlohmann::json out_of_range = nlohmann::json::parse(R"json({
    "/format": ["pleinair-panorama", "pleinair-relight", "PLEINAIR-SEQUENCE", ""],
    "/version": [0, 2, 1.5, -1],
    "/site/latitude_deg": [90.001, -91, 1e308],
    "/site/longitude_deg": [361, -361],
    "/site/height_m": [-1001, 1e7],
    "/site/north_uncertain_deg": [-0.1, 181],
    "/weather": ["sunny", "Clear", ""],
    "/camera/width": [0, -8, 8.5, 65537, 1e12],
    "/camera/height": [0, -8, 6.5, 65537],
    "/camera/fx": [0, -10],
    "/camera/fy": [0, -10, 1e-320],
    "/camera/cx": [1e7, -1e7],
    "/camera/cy": [1e7],
    "/camera/distortion_model": ["fisheye", "brown"],
    "/camera/pixel_centers": ["half"],
    "/camera/camera_from_world": [
      [[2, 0, 0, 0], [0, 0, -2, 0], [0, 2, 0, 0], [0, 0, 0, 1]],
      [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]],
      [[1, 0, 0, 0], [0.01, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]],
      [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]],
      [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0.1, 1]]],
    "/radiometry/frames": ["srgb8"],
    "/radiometry/frames_ldr": ["srgb", "absent.json", ".", "frames"],
    "/scene/mesh": ["absent.obj", "frames", "", "../outside.obj", "/etc/passwd"],
    "/diffuse_regions": [[]],
    "/diffuse_regions/0": [""],
    "/diffuse_mask": ["absent.png", "../outside.obj"],
    "/environment/image": ["absent.exr", "../outside.obj"],
    "/environment/time_utc": ["yesterday", "2005-13-21T09:50:00Z", "2005-06-31T09:50:00Z", ""],
    "/environment/sun_direction_enu": [[0, 0, 0], [1, 1, 1], [0.6, 0, 0.81]],
    "/environment/mapping/type": ["cube"],
    "/environment/mapping/up": ["+Y", "-Z"],
    "/environment/mapping/center": ["-Y (south)", "+X (east)"],
    "/environment/mapping/right": ["-X (west)"],
    "/fisheye/model": ["orthographic"],
    "/fisheye/fov_deg": [0, -180, 361],
    "/fisheye/width": [0, 1.5],
    "/fisheye/height": [-1],
    "/fisheye/calibration": ["absent.yml"],
    "/virtual_object/mesh": ["absent.obj", "../outside.obj"],
    "/virtual_object/world_from_object": [
      [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]],
      [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
      [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 2]]],
    "/frames/0/image": ["../outside.obj", "frames/../../outside.obj", "/x.exr", ""],
    "/frames/0/image_ldr": [".."],
    "/frames/0/fisheye": ["../x"],
    "/frames/0/time_utc": ["2005-06-21", "2005-06-21T25:00:00Z"],
    "/frames/0/exposure": [0, -1, 1e-300],
    "/frames/0/exposure_s": [0, -1],
    "/frames/0/iso": [0, -100],
    "/frames/0/f_number": [0, -2],
    "/frames/0/sun_direction_enu": [[0, 0, 2]],
    "/frames/0/weather": ["rain", "clear "],
    "/frames/0/sample_polygons/0/sun": ["bright"]
  })json");
  for (const auto& [key, values] : out_of_range.items()) {
    for (const nlohmann::json& value : values) {
      nlohmann::json broken = Everything();
      broken[Pointer(key)] = value;
      const std::string refusal = Refusal(broken);
      EXPECT_NE(refusal.find("sequence.json: " + Written(Pointer(key))), std::string::npos)
          << key << " = " << value << ": " << refusal;
      EXPECT_NE(refusal.find("expected"), std::string::npos) << refusal;
    }
  }
}

TEST_F(SequenceHardCases, RefuseUnknownKeysAndLetFreeOnesPass) {
  const nlohmann::json document = Everything();
  std::vector<Pointer> objects{Pointer()};
  for (const Pointer& pointer : AllOf(document)) {
    if (document[pointer].is_object()) objects.push_back(pointer);
  }
  EXPECT_EQ(objects.size(), 13u);
  for (const Pointer& pointer : objects) {
    nlohmann::json broken = document;
    broken[pointer]["sunglasses"] = 1;
    const std::string refusal = Refusal(broken);
    EXPECT_NE(refusal.find("\"sunglasses\""), std::string::npos) << refusal;
    EXPECT_NE(refusal.find(Written(pointer)), std::string::npos) << refusal;
    nlohmann::json annotated = document;
    annotated[pointer]["note_by_hand"] = {{"by", "hand"}, {"on", {2026, 6, 21}}};
    annotated[pointer]["name"] = 7;
    EXPECT_EQ(Refusal(annotated), "accepted");
  }
}

TEST_F(SequenceHardCases, RefuseOneObjectAndAListOfThemTogether) {
  nlohmann::json document = Everything();
  document["virtual_objects"] = {document["virtual_object"]};
  EXPECT_NE(Refusal(document).find("virtual_objects: expected only one"), std::string::npos);
  nlohmann::json elsewhere = document["virtual_object"];
  elsewhere["world_from_object"][0][3] = 1.001;
  document["virtual_objects"] = {document["virtual_object"], elsewhere};
  document.erase("virtual_object");
  EXPECT_EQ(Refusal(document), "accepted");
  document["virtual_objects"].push_back(document["virtual_objects"][0]);
  EXPECT_NE(
      Refusal(document).find("virtual_objects[2]: expected a mesh or a place of its own, other "
                             "than those of virtual_objects[0]"),
      std::string::npos);
}

// What people have: a video, pictures without a sequence.json, or its path.
TEST_F(SequenceHardCases, SayWhatASequenceIsToWhoHasFramesAlone) {
  const auto refusal_of = [](const std::filesystem::path& given) {
    try {
      ReadSequence(given);
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  Write(root_ / "clip.mp4", std::string("\0\0\0\x18", 4) + "ftypmp42 and so on");
  const std::string video = refusal_of(root_ / "clip.mp4");
  for (const char* word : {"clip.mp4: expected a sequence's folder, found an MP4 video",
                           "sequence.json",
                           "docs/sequences.md",
                           "--site SITE"}) {
    EXPECT_NE(video.find(word), std::string::npos) << video;
  }
  std::filesystem::create_directory(root_ / "photos");
  Write(root_ / "photos/readme.txt", "mine");
  Write(root_ / "photos/IMG_2.JPG", "\xff\xd8\xff and so on");
  const std::string photos = refusal_of(root_ / "photos");
  for (const char* word : {"photos/sequence.json: expected a JSON file, found nothing",
                           "IMG_2.JPG (a JPEG picture)",
                           "camera, mesh and each frame's time",
                           "docs/sequences.md"}) {
    EXPECT_NE(photos.find(word), std::string::npos) << photos;
  }
  EXPECT_NE(refusal_of(root_ / "photos/IMG_2.JPG").find("found a JPEG picture: a sequence is"),
            std::string::npos);
  WriteDocument(Everything());
  EXPECT_NE(refusal_of(folder_ / "sequence.json").find("found the file in it"), std::string::npos);
  Write(folder_ / "site.json", "{}");
  EXPECT_NE(refusal_of(folder_ / "site.json").find("found the file in it"), std::string::npos);
}

// A file that is no sequence yet: no mesh, no frames, no place.
TEST_F(SequenceHardCases, GiveTheLensOfAFileThatHasNothingElse) {
  nlohmann::json lens = {{"camera", Everything()["camera"]}};
  Write(root_ / "lens.json", lens.dump());
  EXPECT_EQ(ReadCameraIntrinsics(root_ / "lens.json").fx_px, 10.5);
  WriteDocument(lens);
  EXPECT_EQ(ReadCameraIntrinsics(folder_).distortion[0], -0.1);
  EXPECT_NE(Refusal(lens).find("format: expected"), std::string::npos);
  lens["camera"]["fx"] = -1;
  WriteDocument(lens);
  EXPECT_THROW(ReadCameraIntrinsics(folder_), std::runtime_error);
  WriteDocument({{"format", "pleinair-panorama"}, {"camera", Everything()["camera"]}});
  EXPECT_THROW(ReadCameraIntrinsics(folder_), std::runtime_error);
}

TEST_F(SequenceHardCases, SayThatStillsAreNotHandled) {
  Write(folder_ / "panorama.json", "{}");
  EXPECT_NE(Refusal().find("panorama.json: expected a sequence"), std::string::npos) << Refusal();
  nlohmann::json still = {{"format", "pleinair-relight"}, {"version", 1}};
  EXPECT_NE(Refusal(still).find("stills"), std::string::npos);
}

TEST_F(SequenceHardCases, RefuseWhatIsNoSequenceInOneLine) {
  EXPECT_NE(Refusal().find("sequence.json: expected a JSON file, found nothing"),
            std::string::npos);
  for (const std::string& text : {std::string(),
                                  std::string("\0\0\0", 3),
                                  std::string("[]"),
                                  std::string("{\"format\": \"\xff\"}"),
                                  std::string(300'000, '['),
                                  std::string("{\"format\":") + std::string(300'000, '{'),
                                  std::string("nonsense\n\n")}) {
    Write(folder_ / "sequence.json", text);
    const std::string refusal = Refusal();
    EXPECT_NE(refusal.find("sequence.json: "), std::string::npos) << refusal;
    EXPECT_LT(refusal.size(), 400u + folder_.string().size());
  }
  std::filesystem::remove(folder_ / "sequence.json");
  std::filesystem::create_directory(folder_ / "sequence.json");
  EXPECT_NE(Refusal().find("expected a JSON file"), std::string::npos);
  EXPECT_THROW(ReadSequence(folder_ / "absent"), std::runtime_error);
  EXPECT_THROW(ReadSequence(folder_ / "scene.obj"), std::runtime_error);
}

// Cut anywhere, the document is refused; only the complete one, or a cut in white space, is read.
TEST_F(SequenceHardCases, RefuseATruncatedDocument) {
  const std::string text = Everything().dump();
  for (std::size_t length = 0; length < text.size(); length += 37) {
    Write(folder_ / "sequence.json", text.substr(0, length));
    EXPECT_NE(Refusal(), "accepted") << length;
  }
}

// Bytes changed, cut out and doubled at random: read, or refused in one line, and never a crash.
TEST_F(SequenceHardCases, SurviveRandomDamage) {
  constexpr std::uint64_t kSeed = 11;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  const std::string whole = Everything().dump();
  int refused = 0;
  for (int i = 0; i < 1000; ++i) {
    std::string text = whole;
    for (std::uint64_t damages = 1 + random() % 3; damages > 0; --damages) {
      const std::size_t at = random() % text.size();
      const std::size_t length = std::min<std::size_t>(1 + random() % 40, text.size() - at);
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random() % 256);
          break;
        case 1:
          text.erase(at, length);
          break;
        default:
          text.insert(at, text.substr(at, length));
      }
    }
    Write(folder_ / "sequence.json", text);
    refused += Refusal() == "accepted" ? 0 : 1;
  }
  EXPECT_GT(refused, 500);
}

TEST_F(SequenceHardCases, ReadNothingOutsideTheFolderThroughLinks) {
  namespace fs = std::filesystem;
  fs::create_symlink(root_ / "outside.obj", folder_ / "link.obj");
  fs::create_directory_symlink(root_, folder_ / "link");
  fs::create_symlink("loop.obj", folder_ / "loop.obj");
  fs::create_symlink("scene.obj", folder_ / "inner.obj");
  nlohmann::json document = Everything();
  for (const char* path : {"link.obj", "link/outside.obj", "loop.obj", "link/sequence/x/../../y"}) {
    document["scene"]["mesh"] = path;
    EXPECT_NE(Refusal(document).find("scene.mesh: expected"), std::string::npos) << path;
    if (std::string(path) == "loop.obj") continue;
    nlohmann::json frames = Everything();
    frames["frames"][0]["image"] = path;
    EXPECT_NE(Refusal(frames).find("frames[0].image: expected"), std::string::npos) << path;
  }
  document["scene"]["mesh"] = "inner.obj";
  EXPECT_EQ(Refusal(document), "accepted");
  document["scene"]["mesh"] = "frames/../scene.obj";
  EXPECT_EQ(Refusal(document), "accepted");

  fs::rename(folder_ / "sequence.json", root_ / "sequence.json");
  fs::create_symlink(root_ / "sequence.json", folder_ / "sequence.json");
  EXPECT_NE(Refusal().find("inside the sequence's folder"), std::string::npos);
}

}  // namespace
}  // namespace pleinair::sequence_hard_cases_test
