// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/scene_file.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/sim/mesh_file.h"
#include "prism/sim/procedural_texture.h"
#include "prism/sim/ray_caster.h"
#include "test/io/rgbd_folder.h"

namespace prism {
namespace {

using testing::HasSubstr;

class SceneFileTest : public testing::Test {
 protected:
  SceneFileTest() : folder_(FreshFolder("scene") + "/") {}
  ~SceneFileTest() override { std::filesystem::remove_all(folder_); }

  std::string Write(const std::string& name, const std::string& text) const {
    WriteTextAtomically(folder_ + name, text);
    return folder_ + name;
  }

  std::string SceneWith(const std::string& textures, const std::string& objects) const {
    return Write("scene.yaml",
                 "name: test\npath: {position: [0, 0, 1], target: [1, 0, 1], extent_m: 0.2}\n"
                 "textures:\n  white: {kind: white, pixels: 16}\n" +
                     textures + "objects:\n" + objects);
  }

  static std::string ErrorOf(const std::string& path,
                             SimScene (*read)(const std::string&) = ReadScene) {
    try {
      read(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  std::string folder_;
};

const char kTriangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

TEST_F(SceneFileTest, BuiltInScenesLoadWithTheirStartInFreeSpace) {
  for (const std::string& name : BuiltInScenes()) {
    const SimScene scene = ReadScene(name);
    const RayCaster caster(scene);
    EXPECT_FALSE(caster.IsInside(scene.path.position)) << name;
    EXPECT_GT(caster.Clearance(scene.path.position), 0.2) << name;
    if (name == "facade") {  // a street 60 m long
      EXPECT_NEAR(caster.Cast({{0, 0, 1.7f}, {1, 0, 0}}).t, 60, 1);
    }
  }
}

TEST_F(SceneFileTest, InsideABoxIsInsideAndInsideARoomIsNot) {
  const SimScene scene = ReadScene(
      SceneWith("",
                "  - {kind: room, position: [0, 0, 0], size: [4, 4, 2.5], walls: white, floor: "
                "white, ceiling: white}\n"
                "  - {kind: box, position: [1, 0, 0.5], size: [0.5, 0.5, 0.5], texture: white}\n"));
  const RayCaster caster(scene);
  EXPECT_TRUE(caster.IsInside({1, 0, 0.75}));
  EXPECT_FALSE(caster.IsInside({0, 0, 0.75}));
}

TEST_F(SceneFileTest, ReadsObjPlyAndGltfMeshes) {
  Write("mesh.obj", std::string(kTriangle) + "f 1/1 2/2 3/3\n");
  Write("mesh.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  // Three float positions: (0,0,0), (1,0,0), (0,1,0).
  Write("mesh.gltf",
        R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,)"
        R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0]}]})");
  for (const std::string file : {"mesh.obj", "mesh.ply", "mesh.gltf"}) {
    const SimScene scene = ReadScene(
        SceneWith("", "  - {kind: mesh, file: " + file + ", position: [0, 0, 2], scale: 2}\n"));
    const RayCaster caster(scene);
    const SimHit hit = caster.Cast({{1.5f, 0.25f, 5}, {0, 0, -1}});
    ASSERT_TRUE(hit.found()) << file;
    EXPECT_NEAR(hit.t, 3, 1e-5) << file;
    EXPECT_FALSE(caster.Cast({{1.5f, 0.75f, 5}, {0, 0, -1}}).found()) << file;
  }
}

TEST_F(SceneFileTest, AMeshShowsItsTexture) {
  cv::Mat image(2, 2, CV_8UC3, cv::Scalar(0, 0, 255));  // red
  ASSERT_TRUE(cv::imwrite(folder_ + "red.png", image));
  Write("mesh.mtl", "newmtl m\nmap_Kd red.png\n");
  Write("mesh.obj", "mtllib mesh.mtl\n" + std::string(kTriangle) + "usemtl m\nf 1/1 2/2 3/3\n");
  SimScene scene;
  AddMeshFile(folder_ + "mesh.obj", MeshFileOptions(), &scene);
  const RayCaster caster(scene);
  const Rgb seen = caster.Radiance(caster.Cast({{0.2f, 0.2f, 1}, {0, 0, -1}}), 0);
  EXPECT_NEAR(seen[0], 1, 1e-5);
  EXPECT_NEAR(seen[2], 0, 1e-5);
}

// A binary glTF of one triangle as above, red at every vertex.
std::string RedTriangleGlb() {
  const float values[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0};
  std::string json = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}}]}],
      "buffers": [{"byteLength": 72}],
      "bufferViews": [{"buffer": 0, "byteLength": 36},
                      {"buffer": 0, "byteOffset": 36, "byteLength": 36}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                     "min": [0, 0, 0], "max": [1, 1, 0]},
                    {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}]})";
  while (json.size() % 4 != 0) json += ' ';
  std::string glb = "glTF";
  const auto add = [&](uint32_t value) {
    glb.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  add(2);
  add(static_cast<uint32_t>(12 + 8 + json.size() + 8 + sizeof(values)));
  add(static_cast<uint32_t>(json.size()));
  glb += "JSON" + json;
  add(sizeof(values));
  glb += std::string("BIN\0", 4);
  glb.append(reinterpret_cast<const char*>(values), sizeof(values));
  return glb;
}

TEST_F(SceneFileTest, ASceneThatIsOneMeshNeedsNoTextures) {
  Write("red.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 0\n3 0 1 2\n");
  Write("red.glb", RedTriangleGlb());
  for (const std::string file : {"red.ply", "red.glb"}) {
    const SimScene scene = ReadScene(
        Write("mesh.yaml",
              "name: test\npath: {position: [0, 0, 1], target: [1, 0, 1], extent_m: 0.2}\n"
              "ambient: 1\nobjects:\n  - {kind: mesh, file: " +
                  file + ", position: [0, 0, 0]}\n"));
    const RayCaster caster(scene);
    const SimHit hit = caster.Cast({{0.2f, 0.2f, 1}, {0, 0, -1}});
    ASSERT_TRUE(hit.found()) << file;
    const Rgb seen = caster.Radiance(hit, 0);
    EXPECT_GT(seen[0], 0.1) << file;
    EXPECT_LT(seen[1], 1e-3 * seen[0]) << file;
    EXPECT_LT(seen[2], 1e-3 * seen[0]) << file;
  }
}

TEST_F(SceneFileTest, BadScenesNameTheCause) {
  const std::string box = "  - {kind: box, position: [0, 0, 0], size: [1, 1, 1], texture: ";
  EXPECT_THAT(ErrorOf(folder_ + "none.yaml"), HasSubstr("no readable file"));
  EXPECT_THAT(ErrorOf(SceneWith("", box + "missing}\n")), HasSubstr("unknown texture 'missing'"));
  EXPECT_THAT(ErrorOf(SceneWith("  photo: {file: photo.png}\n", box + "photo}\n")),
              HasSubstr("photo.png: found no such file"));
  EXPECT_THAT(ErrorOf(SceneWith("  x: {kind: velvet}\n", box + "x}\n")), HasSubstr("'velvet'"));
  EXPECT_THAT(ErrorOf(SceneWith("", "  - {kind: ghost}\n")), HasSubstr("kind 'ghost'"));
  EXPECT_THAT(ErrorOf(SceneWith("", box + "white, colour: red}\n")),
              HasSubstr("unknown key 'objects.colour'"));
  EXPECT_THAT(ErrorOf(SceneWith("", "  - {kind: mesh, file: none.obj, position: [0, 0, 0]}\n")),
              HasSubstr("none.obj"));
  Write("broken.ply", "ply\nformat ascii 1.0\nelement vertex nonsense\n");
  EXPECT_THAT(ErrorOf(SceneWith("", "  - {kind: mesh, file: broken.ply, position: [0, 0, 0]}\n")),
              HasSubstr("broken.ply"));
  Write("untextured.mtl", "newmtl m\nmap_Kd lost.png\n");
  Write("lost.obj",
        "mtllib untextured.mtl\n" + std::string(kTriangle) + "usemtl m\nf 1/1 2/2 3/3\n");
  EXPECT_THAT(ErrorOf(SceneWith("", "  - {kind: mesh, file: lost.obj, position: [0, 0, 0]}\n")),
              HasSubstr("lost.png: found no such file"));
  for (const std::string& message : {ErrorOf(SceneWith("", "  - {kind: ghost}\n")),
                                     ErrorOf(SceneWith("", box + "missing}\n"))}) {
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST_F(SceneFileTest, FiguresOutOfRangeAreNamed) {
  const std::string at = ", position: [0, 0, 0], texture: white, ";
  const auto error_of = [&](const std::string& object) {
    return ErrorOf(SceneWith("", "  - {" + object + "}\n"));
  };
  const std::string facade =
      "kind: facade, position: [0, 0, 0], size: [9, 1, 9], wall: white, frame: white, glass: white";
  EXPECT_THAT(error_of(facade + ", columns: 0, floors: 2"),
              HasSubstr("found 'objects.columns' of 0, expected 1 to 100"));
  EXPECT_THAT(error_of(facade + ", columns: 2, floors: 1000000000"),
              HasSubstr("'objects.floors' of 1000000000"));
  const std::string shelf = "kind: bookshelf, position: [0, 0, 0], frame: white, books: white";
  EXPECT_THAT(error_of(shelf + ", size: [1, 0.3, 2], shelves: 0"), HasSubstr("'objects.shelves'"));
  EXPECT_THAT(error_of(shelf + ", size: [1.0e+300, 0.3, 2]"),  // no book is so wide
              HasSubstr("'objects.size' of 1e+300 m, expected more than 0 m, at most 100"));
  EXPECT_THAT(error_of("kind: table, position: [0, 0, 0], size: [1, 1, 1], wood: white, things: "
                       "white, num_things: 2000000000"),
              HasSubstr("'objects.num_things'"));
  EXPECT_THAT(error_of("kind: sofa, position: [0, 0, 0], size: [1.0e+12, 1, 1], fabric: white, "
                       "cushions: white"),
              HasSubstr("'objects.size'"));
  EXPECT_THAT(error_of("kind: box" + at + "size: [1, -1, 1]"), HasSubstr("'objects.size' of -1"));
  EXPECT_THAT(error_of("kind: sphere" + at + "radius: 0"), HasSubstr("'objects.radius' of 0"));
  EXPECT_THAT(error_of("kind: cylinder" + at + "radius: 1, height: -1"),
              HasSubstr("'objects.height' of -1"));
  EXPECT_THAT(error_of("kind: quad, corner: [0, 0, 0], right: [1, 0, 0], down: [2, 0, 0], "
                       "texture: white"),
              HasSubstr("a quad without area"));
  EXPECT_THAT(error_of("kind: quad, corner: [0, 0, 0], right: [1.0e+30, 0, 0], down: [0, 0, 1], "
                       "texture: white"),
              HasSubstr("out of sight"));
  std::string textures;
  for (int i = 0; i < 5; ++i) {
    textures += "  t" + std::to_string(i) + ": {kind: white, pixels: 8192}\n";
  }
  EXPECT_THAT(ErrorOf(SceneWith(textures, "  - {kind: ghost}\n"), ReadSceneShape),
              HasSubstr("textures of more than 4 x 8192 x 8192 px"));
}

TEST_F(SceneFileTest, TheShapeIsTheSceneInWhite) {
  const SimScene scene = ReadScene("plane");
  const SimScene shape = ReadSceneShape("plane");
  ASSERT_EQ(shape.meshes.size(), scene.meshes.size());
  ASSERT_EQ(shape.meshes[0].vertices.size(), scene.meshes[0].vertices.size());
  EXPECT_EQ(shape.meshes[0].vertices[7].position, scene.meshes[0].vertices[7].position);
  EXPECT_EQ(shape.textures.size(), scene.textures.size());
}

TEST_F(SceneFileTest, TexturesAreReproducibleAndHaveManyScales) {
  for (const std::string& kind : ProceduralTextureKinds()) {
    const cv::Mat texture = MakeTexture(kind, 256, 7);
    EXPECT_EQ(cv::norm(texture, MakeTexture(kind, 256, 7), cv::NORM_INF), 0) << kind;
    if (kind != "white") {
      EXPECT_GT(cv::norm(texture, MakeTexture(kind, 256, 8), cv::NORM_INF), 0) << kind;
    }
  }
}

}  // namespace
}  // namespace prism
