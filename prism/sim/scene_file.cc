// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/scene_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include "prism/base/error.h"
#include "prism/board/calibration_board.h"
#include "prism/io/yaml_section.h"
#include "prism/sim/built_in_scenes.h"
#include "prism/sim/furniture.h"
#include "prism/sim/lighting.h"
#include "prism/sim/mesh_file.h"
#include "prism/sim/procedural_texture.h"
#include "prism/sim/ray_caster.h"
#include "prism/sim/scene_builder.h"

namespace prism {
namespace {

constexpr char kPosition[] = "[x, y, z] in m, z up";
constexpr char kSizeMetres[] = "[width, depth, height] in m";
constexpr double kLargest = 1e4;                                   // m
constexpr double kLargestFurniture = 100;                          // m
constexpr int kMaxCount = 100;                                     // shelves, floors, things
constexpr int kMaxTexture = 8192;                                  // px, a side
constexpr int64_t kMaxTextures = 4LL * kMaxTexture * kMaxTexture;  // px, all that are drawn
constexpr size_t kMaxVertices = 20'000'000;

// What the objects of one description have in common.
struct Context {
  std::string path;
  bool white = false;  // textures are not drawn
  std::map<std::string, SurfaceTexture> textures;
  int64_t texture_px = 0;
  SimScene scene;

  // What `draw` returns, or white.
  template <typename Draw>
  void AddTexture(const Draw& draw) {
    scene.textures.emplace_back(white ? cv::Mat(1, 1, CV_8U, cv::Scalar(255)) : draw());
  }

  SurfaceTexture TextureOf(YamlSection& object, const std::string& key) const {
    const auto name = object.Value<std::string>(key, "the name of a texture");
    const auto found = textures.find(name);
    if (found == textures.end()) {
      throw InputError(path, "the unknown texture '" + name + "'", "a name under 'textures'");
    }
    return found->second;
  }

  std::string Resolve(const std::string& file) const {
    return (std::filesystem::path(path).parent_path() / file).string();
  }
};

void CheckLength(const Context& context, const std::string& key, double length, double largest) {
  if (length > 0 && length <= largest) return;
  std::ostringstream found;
  std::ostringstream expected;
  found << "'objects." << key << "' of " << length << " m";
  expected << "more than 0 m, at most " << largest;
  throw InputError(context.path, found.str(), expected.str());
}

double LengthOf(YamlSection& object, const std::string& key, const Context& context) {
  const auto length = object.Value<double>(key, "m");
  CheckLength(context, key, length, kLargest);
  return length;
}

Eigen::Vector3d SizeOf(YamlSection& object, const Context& context, double largest = kLargest) {
  Eigen::Vector3d size = object.Vector<3>("size", kSizeMetres);
  for (const double length : size) CheckLength(context, "size", length, largest);
  return size;
}

int CheckedCount(const Context& context, const std::string& key, int count, int least) {
  if (count >= least && count <= kMaxCount) return count;
  throw InputError(context.path,
                   "'objects." + key + "' of " + std::to_string(count),
                   std::to_string(least) + " to " + std::to_string(kMaxCount));
}

Eigen::Isometry3d PlacementOf(YamlSection& object) {
  return Placement(object.Vector<3>("position", kPosition),
                   object.ValueOr("yaw_deg", 0.0, "an angle in degrees"));
}

Rgb ColourOr(YamlSection& section, const std::string& key, const Rgb& fallback) {
  if (!section.Has(key)) return fallback;
  return section.Vector<3>(key, "[red, green, blue]").cast<float>().array();
}

void ReadTextureEntry(const std::string& name, const YAML::Node& node, Context* context) {
  YamlSection section(context->path, "textures." + name, node);
  SurfaceTexture texture;
  texture.index = static_cast<int>(context->scene.textures.size());
  texture.style.tint = ColourOr(section, "tint", Rgb::Ones());
  if (section.Has("size_m")) {
    texture.style.texture_size = section.Vector<2>("size_m", "[width, height] in m");
    if (!(texture.style.texture_size.minCoeff() > 0)) {
      throw InputError(context->path, "textures." + name + ".size_m that is not > 0", "m");
    }
  }
  if (section.Has("file")) {
    const auto file = section.Value<std::string>("file", "an image");
    context->scene.textures.push_back(ReadTexture(context->Resolve(file)));
  } else {
    const auto kind = section.Value<std::string>("kind", "a kind of texture (or 'file')");
    const auto& kinds = ProceduralTextureKinds();
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
      std::string expected = "one of";
      for (const std::string& k : kinds) expected += " " + k;
      throw InputError(context->path, "the texture kind '" + kind + "'", expected);
    }
    const int pixels = section.ValueOr("pixels", 1024, "a side in px");
    if (pixels < 16 || pixels > kMaxTexture) {
      throw InputError(context->path, std::to_string(pixels) + " px", "16 to 8192 px");
    }
    context->texture_px += static_cast<int64_t>(pixels) * pixels;
    if (context->texture_px > kMaxTextures) {
      throw InputError(context->path, "textures of more than 4 x 8192 x 8192 px", "fewer of them");
    }
    const auto seed = section.ValueOr<uint64_t>("seed", 1, "a seed");
    context->AddTexture([&] { return MakeTexture(kind, pixels, seed); });
  }
  section.RejectUnknownKeys();
  context->textures[name] = texture;
}

// ---- objects, one function a kind ----

void ReadRoom(YamlSection& object, Context* context) {
  const Eigen::Vector3d position = object.Vector<3>("position", kPosition);
  const Eigen::Vector3d size = SizeOf(object, *context);
  const SurfaceTexture wall = context->TextureOf(object, "walls");
  const SurfaceTexture floor = context->TextureOf(object, "floor");
  const SurfaceTexture ceiling = context->TextureOf(object, "ceiling");
  SimScene* scene = &context->scene;
  const Eigen::Vector3d low = position - Eigen::Vector3d(0.5 * size.x(), 0.5 * size.y(), 0);
  const double x = size.x();
  const double y = size.y();
  const double z = size.z();
  SimMesh* walls = MeshOf(wall.index, false, scene);
  const auto add_wall = [&](const Eigen::Vector3d& corner, const Eigen::Vector3d& right) {
    AddQuad(low + corner, right, {0, 0, -z}, wall.style, walls);
  };
  add_wall({0, y, z}, {x, 0, 0});
  add_wall({x, y, z}, {0, -y, 0});
  add_wall({x, 0, z}, {-x, 0, 0});
  add_wall({0, 0, z}, {0, y, 0});
  AddQuad(low + Eigen::Vector3d(0, y, 0),
          {x, 0, 0},
          {0, -y, 0},
          floor.style,
          MeshOf(floor.index, false, scene));
  AddQuad(low + Eigen::Vector3d(0, 0, z),
          {x, 0, 0},
          {0, y, 0},
          ceiling.style,
          MeshOf(ceiling.index, false, scene));
}

void ReadQuad(YamlSection& object, Context* context) {
  const SurfaceTexture texture = context->TextureOf(object, "texture");
  const Eigen::Vector3d right = object.Vector<3>("right", kPosition);
  const Eigen::Vector3d down = object.Vector<3>("down", kPosition);
  if (!(right.cross(down).norm() > 0)) {
    throw InputError(context->path, "a quad without area", "'right' across 'down'");
  }
  AddQuad(object.Vector<3>("corner", kPosition),
          right,
          down,
          texture.style,
          MeshOf(texture.index, true, &context->scene));
}

// A board whose middle is at `position`, seen from -x; the world's z is up on it.
void ReadCalibrationBoard(YamlSection& object, Context* context) {
  CalibrationBoard board;
  const auto pattern = object.ValueOr<std::string>("pattern", "charuco", "a pattern");
  if (!ParseBoardPattern(pattern, &board.pattern)) {
    throw InputError(context->path, "the pattern '" + pattern + "'", "charuco or checkerboard");
  }
  const std::array<int, 2> squares = object.Size("squares");
  board.columns = squares[0];
  board.rows = squares[1];
  board.square_m = object.Value<double>("square_m", "the side of a square in m");
  std::string error;
  if (!board.IsValid(&error)) throw InputError(context->path, error, "a board");
  // With a white margin of one square.
  const double width = (board.columns + 2) * board.square_m;
  const double height = (board.rows + 2) * board.square_m;
  const Eigen::Vector3d middle =
      object.Has("position") ? object.Vector<3>("position", kPosition) : Eigen::Vector3d::Zero();
  const int square_px = std::min(256, kMaxTexture / (std::max(board.columns, board.rows) + 2));
  context->AddTexture([&] { return DrawBoard(board, square_px, square_px); });
  AddQuad(middle + Eigen::Vector3d(0, width / 2, height / 2),
          {0, -width, 0},
          {0, 0, -height},
          SurfaceStyle{},
          MeshOf(static_cast<int>(context->scene.textures.size()) - 1, true, &context->scene));
}

void ReadBox(YamlSection& object, Context* context) {
  AddTexturedBox(PlacementOf(object),
                 SizeOf(object, *context),
                 context->TextureOf(object, "texture"),
                 &context->scene,
                 ColourOr(object, "tint", Rgb::Ones()));
}

void ReadCylinder(YamlSection& object, Context* context) {
  const SurfaceTexture texture = context->TextureOf(object, "texture");
  const double radius = LengthOf(object, "radius", *context);
  AddCylinder(PlacementOf(object),
              radius,
              object.Has("top_radius") ? LengthOf(object, "top_radius", *context) : radius,
              LengthOf(object, "height", *context),
              texture.style,
              MeshOf(texture.index, false, &context->scene));
}

void ReadSphere(YamlSection& object, Context* context) {
  const SurfaceTexture texture = context->TextureOf(object, "texture");
  AddSphere(PlacementOf(object),
            LengthOf(object, "radius", *context),
            texture.style,
            MeshOf(texture.index, false, &context->scene));
}

void ReadMesh(YamlSection& object, Context* context) {
  MeshFileOptions options;
  options.world_from_mesh = PlacementOf(object);
  if (object.ValueOr("y_up", false, "true or false")) {
    options.world_from_mesh.rotate(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  }
  options.scale = object.ValueOr("scale", 1.0, "metres a unit of the file");
  options.double_sided = object.ValueOr("double_sided", true, "true or false");
  if (object.Has("texture")) options.texture = context->TextureOf(object, "texture").index;
  const auto file = object.Value<std::string>("file", "a mesh in OBJ, PLY or glTF");
  AddMeshFile(context->Resolve(file), options, &context->scene);
}

uint64_t SeedOf(YamlSection& object) { return object.ValueOr<uint64_t>("seed", 1, "a seed"); }

void ReadBookshelf(YamlSection& object, Context* context) {
  AddBookshelf(PlacementOf(object),
               SizeOf(object, *context, kLargestFurniture),
               CheckedCount(*context, "shelves", object.ValueOr("shelves", 5, "a count"), 1),
               context->TextureOf(object, "frame"),
               context->TextureOf(object, "books"),
               SeedOf(object),
               &context->scene);
}

void ReadTable(YamlSection& object, Context* context) {
  AddTable(PlacementOf(object),
           SizeOf(object, *context, kLargestFurniture),
           context->TextureOf(object, "wood"),
           context->TextureOf(object, "things"),
           CheckedCount(*context, "num_things", object.ValueOr("num_things", 8, "a count"), 0),
           SeedOf(object),
           &context->scene);
}

void ReadChair(YamlSection& object, Context* context) {
  AddChair(PlacementOf(object),
           context->TextureOf(object, "wood"),
           context->TextureOf(object, "seat"),
           &context->scene);
}

void ReadSofa(YamlSection& object, Context* context) {
  AddSofa(PlacementOf(object),
          SizeOf(object, *context, kLargestFurniture),
          context->TextureOf(object, "fabric"),
          context->TextureOf(object, "cushions"),
          SeedOf(object),
          &context->scene);
}

void ReadPlant(YamlSection& object, Context* context) {
  AddPlant(PlacementOf(object),
           LengthOf(object, "height", *context),
           context->TextureOf(object, "pot"),
           context->TextureOf(object, "leaves"),
           SeedOf(object),
           &context->scene);
}

void ReadFacade(YamlSection& object, Context* context) {
  AddFacade(PlacementOf(object),
            SizeOf(object, *context),
            CheckedCount(*context, "columns", object.Value<int>("columns", "windows in a row"), 1),
            CheckedCount(*context, "floors", object.Value<int>("floors", "rows of windows"), 1),
            context->TextureOf(object, "wall"),
            context->TextureOf(object, "frame"),
            context->TextureOf(object, "glass"),
            &context->scene);
}

void ReadObject(const YAML::Node& node, Context* context) {
  using Reader = void (*)(YamlSection&, Context*);
  static const auto* readers =
      new std::map<std::string, Reader>{{"room", ReadRoom},
                                        {"quad", ReadQuad},
                                        {"box", ReadBox},
                                        {"calibration_board", ReadCalibrationBoard},
                                        {"cylinder", ReadCylinder},
                                        {"sphere", ReadSphere},
                                        {"mesh", ReadMesh},
                                        {"bookshelf", ReadBookshelf},
                                        {"table", ReadTable},
                                        {"chair", ReadChair},
                                        {"sofa", ReadSofa},
                                        {"plant", ReadPlant},
                                        {"facade", ReadFacade}};
  YamlSection object(context->path, "objects", node);
  std::string expected = "one of";
  for (const auto& [kind, reader] : *readers) expected += " " + kind;
  const auto kind = object.Value<std::string>("kind", expected);
  const auto reader = readers->find(kind);
  if (reader == readers->end()) {
    throw InputError(context->path, "an object of kind '" + kind + "'", expected);
  }
  reader->second(object, context);
  object.RejectUnknownKeys();
  size_t vertices = 0;
  for (const SimMesh& mesh : context->scene.meshes) vertices += mesh.vertices.size();
  if (vertices > kMaxVertices) {
    throw InputError(context->path, "more than 20 million vertices", "a smaller scene");
  }
}

SimScene ReadRoot(const std::string& path, bool white, const YAML::Node& node) {
  Context context;
  context.path = path;
  context.white = white;
  SimScene& scene = context.scene;
  YamlSection root(path, "", node);
  scene.name = root.Value<std::string>("name", "the scene's name");
  scene.ambient = root.ValueOr("ambient", scene.ambient, "irradiance under an open sky");
  scene.background = ColourOr(root, "background", scene.background);
  if (root.Has("sun")) {
    YamlSection sun(path, "sun", root.Get("sun", ""));
    const Eigen::Vector3d direction = sun.Vector<3>("direction", "[x, y, z] towards the sun");
    if (!(direction.norm() > 0)) throw InputError(path, "a sun without direction", "[x, y, z]");
    scene.sun_direction = direction.normalized().cast<float>();
    scene.sun = sun.Value<float>("irradiance", "a number");
    sun.RejectUnknownKeys();
  }
  YamlSection motion(path, "path", root.Get("path", "where trajectories take place"));
  scene.path.position = motion.Vector<3>("position", kPosition);
  scene.path.target = motion.Vector<3>("target", kPosition);
  scene.path.extent = motion.Value<double>("extent_m", "of the motion");
  motion.RejectUnknownKeys();
  for (const auto& lamp_node : root.Has("lamps") ? root.Get("lamps", "") : YAML::Node()) {
    YamlSection lamp(path, "lamps", lamp_node);
    scene.lamps.push_back({lamp.Vector<3>("position", kPosition).cast<float>(),
                           lamp.Value<float>("size", "a side in m"),
                           lamp.Value<float>("power", "irradiance at 1 m")});
    lamp.RejectUnknownKeys();
  }
  // A mesh has its own, or the colours of its vertices.
  for (const auto& entry :
       root.Has("textures") ? root.Get("textures", "textures by name") : YAML::Node()) {
    ReadTextureEntry(entry.first.as<std::string>(), entry.second, &context);
  }
  for (const auto& object : root.Get("objects", "a list of objects")) ReadObject(object, &context);
  root.RejectUnknownKeys();
  if (scene.meshes.empty()) throw InputError(path, "no objects", "at least one");
  for (const SimMesh& mesh : scene.meshes) {
    for (const SimMesh::Vertex& vertex : mesh.vertices) {
      if (!(vertex.position.array().abs() < 1e6f).all()) {
        throw InputError(path, "an object out of sight", "objects within 1000 km");
      }
    }
  }
  return scene;
}

SimScene ReadDescription(const std::string& name_or_path, bool white) {
  constexpr char kExpected[] = "a scene description in YAML";
  const auto read = [&](const YAML::Node& node) { return ReadRoot(name_or_path, white, node); };
  const std::map<std::string, const char*> built_in = {{"board", kBoardScene},
                                                       {"facade", kFacadeScene},
                                                       {"plane", kPlaneScene},
                                                       {"room", kRoomScene}};
  const auto found = built_in.find(name_or_path);
  return found != built_in.end() ? ParseYamlText(name_or_path, found->second, kExpected, read)
                                 : ParseYamlFile(name_or_path, kExpected, read);
}

}  // namespace

std::vector<std::string> BuiltInScenes() { return {"board", "facade", "plane", "room"}; }

SimScene ReadScene(const std::string& name_or_path) {
  SimScene scene = ReadDescription(name_or_path, false);
  const RayCaster caster(scene);
  BakeLighting(caster, 1, &scene);
  return scene;
}

SimScene ReadSceneShape(const std::string& name_or_path) {
  return ReadDescription(name_or_path, true);
}

}  // namespace prism
