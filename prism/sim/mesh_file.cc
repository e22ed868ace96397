// SPDX-FileCopyrightText: The PRISM-VO developers
// SPDX-License-Identifier: BSD-3-Clause
#include "prism/sim/mesh_file.h"

#include <filesystem>
#include <map>
#include <sstream>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <opencv2/imgcodecs.hpp>

#include "prism/base/error.h"
#include "prism/io/atomic_file.h"
#include "prism/io/image_file.h"

namespace prism {
namespace {

int AddTexture(const Texture& texture, SimScene* scene) {
  scene->textures.push_back(texture);
  return static_cast<int>(scene->textures.size()) - 1;
}

// Index of the diffuse texture of a material, loaded on first use; -1 if it has none.
int DiffuseTexture(const std::string& path,
                   const aiScene& file,
                   const aiMaterial& material,
                   std::map<std::string, int>* loaded,
                   SimScene* scene) {
  aiString name;
  if (material.GetTexture(aiTextureType_DIFFUSE, 0, &name) != AI_SUCCESS) return -1;
  const auto known = loaded->find(name.C_Str());
  if (known != loaded->end()) return known->second;
  int index = -1;
  if (const aiTexture* embedded = file.GetEmbeddedTexture(name.C_Str())) {
    cv::Mat image;
    if (embedded->mHeight == 0) {
      const cv::Mat bytes(1, static_cast<int>(embedded->mWidth), CV_8U, embedded->pcData);
      image = cv::imdecode(bytes, cv::IMREAD_COLOR);
    }
    if (image.empty()) {
      throw InputError(path, "an embedded texture that does not decode", "PNG or JPEG");
    }
    index = AddTexture(Texture(image), scene);
  } else {
    const auto folder = std::filesystem::path(path).parent_path();
    index = AddTexture(ReadTexture((folder / name.C_Str()).string()), scene);
  }
  (*loaded)[name.C_Str()] = index;
  return index;
}

SimMesh Convert(const std::string& path,
                const aiMesh& source,
                const Rgb& colour,
                const MeshFileOptions& options) {
  constexpr float kFar = 1e6f;  // m
  SimMesh mesh;
  mesh.double_sided = options.double_sided;
  mesh.vertices.resize(source.mNumVertices);
  for (unsigned i = 0; i < source.mNumVertices; ++i) {
    SimMesh::Vertex& vertex = mesh.vertices[i];
    const aiVector3D& p = source.mVertices[i];
    const aiVector3D& n = source.mNormals[i];
    const Eigen::Vector3d position = options.scale * Eigen::Vector3d(p.x, p.y, p.z);
    vertex.position = (options.world_from_mesh * position).cast<float>();
    if (!(vertex.position.array().abs() < kFar).all()) {
      std::ostringstream found;
      found << "a vertex at (" << p.x << ", " << p.y << ", " << p.z << ")";
      throw InputError(path, found.str(), "vertices within 1000 km");
    }
    vertex.normal = (options.world_from_mesh.linear() * Eigen::Vector3d(n.x, n.y, n.z))
                        .normalized()
                        .cast<float>();
    // Vertices of degenerate triangles have no normal.
    if (!(vertex.normal.norm() > 0.5f)) vertex.normal = Eigen::Vector3f::UnitZ();
    if (source.HasTextureCoords(0)) {
      const aiVector3D& uv = source.mTextureCoords[0][i];
      vertex.uv = {uv.x, 1 - uv.y};  // v runs down here
      if (!vertex.uv.allFinite()) {
        throw InputError(path, "texture coordinates that are not finite", "finite ones");
      }
    }
    vertex.shade = colour;
    if (source.HasVertexColors(0)) {
      const aiColor4D& c = source.mColors[0][i];
      vertex.shade *= Rgb(c.r, c.g, c.b);
    }
  }
  for (unsigned i = 0; i < source.mNumFaces; ++i) {
    const aiFace& face = source.mFaces[i];
    if (face.mNumIndices != 3) continue;
    mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
  }
  return mesh;
}

}  // namespace

Texture ReadTexture(const std::string& path) {
  cv::Mat image = ReadImageUnchanged(path);
  if (image.depth() != CV_8U) image.convertTo(image, CV_8U, 1.0 / 257);
  if (image.channels() == 4) return Texture(cv::imread(path, cv::IMREAD_COLOR));
  return Texture(image);
}

void AddMeshFile(const std::string& path, const MeshFileOptions& options, SimScene* scene) {
  // assimp 5.2 loops for ever on a PLY header that does not end.
  if (std::filesystem::path(path).extension() == ".ply" &&
      ReadTextFile(path).find("end_header") == std::string::npos) {
    throw InputError(path, "a header without end", "a mesh in PLY");
  }
  Assimp::Importer importer;
  const aiScene* file = importer.ReadFile(
      path,
      aiProcess_Triangulate | aiProcess_GenSmoothNormals | aiProcess_JoinIdenticalVertices |
          aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (file == nullptr) {
    std::string error = importer.GetErrorString();
    for (char& c : error) {
      if (c == '\n' || c == '\r') c = ' ';
    }
    throw InputError(path, "'" + error + "'", "a mesh in OBJ, PLY or glTF");
  }
  std::map<std::string, int> loaded;
  int white = options.texture;
  size_t num_triangles = 0;
  for (unsigned i = 0; i < file->mNumMeshes; ++i) {
    const aiMesh& source = *file->mMeshes[i];
    const aiMaterial& material = *file->mMaterials[source.mMaterialIndex];
    aiColor3D diffuse(1, 1, 1);
    int texture =
        source.HasTextureCoords(0) ? DiffuseTexture(path, *file, material, &loaded, scene) : -1;
    if (texture < 0) {
      material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
      if (white < 0) white = AddTexture(Texture(cv::Mat(1, 1, CV_8UC1, cv::Scalar(255))), scene);
      texture = white;
    }
    SimMesh mesh = Convert(path, source, Rgb(diffuse.r, diffuse.g, diffuse.b), options);
    mesh.texture = texture;
    num_triangles += mesh.triangles.size();
    if (!mesh.triangles.empty()) scene->meshes.push_back(std::move(mesh));
  }
  if (num_triangles == 0) throw InputError(path, "no triangles", "a mesh");
}

}  // namespace prism
