// A sequence in a temporary folder, with every key of the format, for the tests to break.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "datasets/sequence.h"
#include "scene/image_io.h"

namespace pleinair {

class SequenceFolder : public testing::Test {
 protected:
  // The calibration of the lens and the orientation that Everything() states.
  static constexpr const char* kFisheyeCalibration = R"json({
    "format": "pleinair-fisheye", "version": 1, "model": "equidistant",
    "width": 512, "height": 500, "fx": 159, "fy": 159, "cx": 255.5, "cy": 249.5, "fov_deg": 180,
    "orientation_world_from_camera": [[1, 0, 0], [0, -1, 0], [0, 0, 1]]
  })json";

  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    root_ = std::filesystem::path(testing::TempDir()) /
            (std::string("pleinair_") + test->test_suite_name() + "_" + test->name());
    std::filesystem::remove_all(root_);
    folder_ = root_ / "sequence";
    std::filesystem::create_directories(folder_ / "frames");
    // Presence is all that reading a sequence asks of these.
    for (const char* file : {"scene.obj", "environment.exr", "object.obj", "response.json"}) {
      Write(folder_ / file, "x");
    }
    // Its size says that it is over the map.
    WritePng(folder_ / "mask.png", Gray8Image(2, 1, 255));
    Write(folder_ / "fisheye.json", kFisheyeCalibration);
    Write(root_ / "outside.obj", "x");
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  static void Write(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
  }
  void WriteDocument(const nlohmann::json& document) {
    Write(folder_ / "sequence.json", document.dump());
  }

  // The refusal's text, or "accepted".
  std::string Refusal(const nlohmann::json& document) {
    WriteDocument(document);
    return Refusal();
  }
  std::string Refusal() {
    try {
      ReadSequence(folder_);
    } catch (const std::runtime_error& error) {
      std::string text = error.what();
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      return text;
    }
    return "accepted";
  }

  static nlohmann::json Everything() {
    return nlohmann::json::parse(R"json({
      "format": "pleinair-sequence", "version": 1, "name": "everything",
      "world": "ENU", "note_source": "made up",
      "site": {"latitude_deg": 57.0488, "longitude_deg": 9.9217, "height_m": 15.0,
        "north_uncertain_deg": 2.5},
      "weather": "broken",
      "camera": {"width": 8, "height": 6, "fx": 10.5, "fy": 10.25, "cx": 3.5, "cy": 2.5,
        "distortion": [-0.1, 0.01, 0.001, -0.001, 0.0], "distortion_model": "opencv",
        "pixel_centers": "integer",
        "camera_from_world": [[1, 0, 0, 0.5], [0, 0, -1, 1.5], [0, 1, 0, 2.5], [0, 0, 0, 1]]},
      "radiometry": {"frames": "linear", "frames_ldr": "srgb8"},
      "scene": {"mesh": "scene.obj", "albedos_known": false, "albedos_assumed": true},
      "windows": [{"name": "south", "polygon_world_m": [[0, 0, 0], [1, 0, 0], [1, 0, 2]]}],
      "diffuse_regions": ["paving", "wall"],
      "diffuse_mask": "mask.png",
      "environment": {"image": "environment.exr", "position_m": [-1.25, 2, 1.5],
        "time_utc": "2005-06-21T09:50:00.25Z", "sun_direction_enu": [0.6, 0.0, 0.8],
        "mapping": {"type": "equirectangular", "up": "+Z", "center": "+Y (north)",
          "right": "+X (east)", "formula": "free"
}
}
, "fisheye" : {
  "model" : "equidistant",
  "fov_deg" : 180,
  "width" : 512,
  "height" : 500,
  "up" : "+Z",
  "image_up" : "+Y north",
  "image_right" : "+X east",
  "position_m" : [ 2, 2, 3.5 ],
  "calibration" : "fisheye.json"
},
              "virtual_object"
    : {
      "mesh" : "object.obj",
      "world_from_object" : [ [ 2, 0, 0, 1 ], [ 0, 2, 0, 2 ], [ 0, 0, 2, 3 ], [ 0, 0, 0, 1 ] ]
    },
      "frames"
    : [
      {
        "image" : "frames/0.exr",
        "image_ldr" : "frames/0.png",
        "fisheye" : "frames/f0.exr",
        "time_utc" : "2005-06-21T10:00:00Z",
        "exposure" : 0.0125,
        "exposure_s" : 0.001,
        "iso" : 100,
        "f_number" : 2.5,
        "camera_from_world" : [ [ 0, -1, 0, 0 ], [ 0, 0, -1, 0 ], [ 1, 0, 0, 0 ], [ 0, 0, 0, 1 ] ],
        "sun_direction_enu" : [ 0.0, -0.6, 0.8 ],
        "weather" : "clear",
        "sample_polygons" : [ {
          "material" : "brick",
          "group" : "wall",
          "sun" : "grazing",
          "polygon_px" : [ [ 0, 0 ], [ 4.5, 0 ], [ 4.5, 3 ] ]
        } ]
      },
      {"image_ldr" : "frames/1.png", "time_utc" : "2005-06-21T10:30:00.5Z"}
    ]
    })json");
  }

  std::filesystem::path root_;
  std::filesystem::path folder_;
};

}  // namespace pleinair
