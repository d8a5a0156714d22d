// SPDX-License-Identifier: MIT
//
// The child process: writes assimp's scene as a stream. It runs after fork() with a single thread;
// errors end the child, not the caller.
#include "import/assimp/assimp_files.h"
#include "import/assimp/assimp_writer.h"

#include <assert.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void flush(stp_assimp_writer* w)
{
    for (size_t at = 0; at < w->used && !w->failed;) {
        ssize_t done = write(w->descriptor, w->buffer + at, w->used - at);
        w->failed = done < 0 && errno != EINTR;
        at += done > 0 ? (size_t)done : 0;
    }
    w->used = 0;
}

void stp_assimp_put(stp_assimp_writer* w, const void* bytes, size_t size)
{
    const unsigned char* at = bytes;
    while (size > 0 && !w->failed) {
        assert(w->used < STP_ASSIMP_BUFFER_SIZE && "a full buffer was flushed");
        size_t room = STP_ASSIMP_BUFFER_SIZE - w->used;
        size_t part = size < room ? size : room;
        memcpy(w->buffer + w->used, at, part);
        w->used += part;
        at += part;
        size -= part;
        if (w->used == STP_ASSIMP_BUFFER_SIZE) {
            flush(w);
        }
    }
}

void stp_assimp_put_u32(stp_assimp_writer* w, uint32_t value)
{
    stp_assimp_put(w, &value, sizeof(value));
}

void stp_assimp_put_text(stp_assimp_writer* w, const char* text, size_t length)
{
    length = length < STP_ASSIMP_TEXT_LIMIT ? length : STP_ASSIMP_TEXT_LIMIT;
    stp_assimp_put_u32(w, (uint32_t)length);
    stp_assimp_put(w, text, length);
}

void stp_assimp_put_string(stp_assimp_writer* w, const struct aiString* string)
{
    stp_assimp_put_text(w, string->data, string->length);
}

static void put_texcoords(stp_assimp_writer* w, const struct aiMesh* mesh, int set)
{
    for (unsigned i = 0; i < mesh->mNumVertices; ++i) {
        float uv[2] = {mesh->mTextureCoords[set][i].x, mesh->mTextureCoords[set][i].y};
        stp_assimp_put(w, uv, sizeof(uv));
    }
}

static void put_mesh(stp_assimp_writer* w, const struct aiMesh* mesh)
{
    int points = (mesh->mPrimitiveTypes & aiPrimitiveType_POINT) != 0;
    int triangles = (mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE) != 0;
    stp_assimp_mesh head = {.material = mesh->mMaterialIndex};
    if ((points || triangles) && mesh->mVertices != NULL) { // skips lines
        head.vertex_count = mesh->mNumVertices;
        head.flags = (mesh->mNormals != NULL ? STP_ASSIMP_NORMALS : 0u) |
                     (mesh->mTextureCoords[0] != NULL ? STP_ASSIMP_TEXCOORDS_0 : 0u) |
                     (mesh->mTextureCoords[1] != NULL ? STP_ASSIMP_TEXCOORDS_1 : 0u) |
                     (mesh->mColors[0] != NULL ? STP_ASSIMP_COLORS : 0u) |
                     (triangles ? 0u : STP_ASSIMP_POINTS);
    }
    for (unsigned i = 0; triangles && i < mesh->mNumFaces; ++i) {
        head.triangle_count += mesh->mFaces[i].mNumIndices == 3;
    }
    stp_assimp_put_string(w, &mesh->mName);
    stp_assimp_put(w, &head, sizeof(head));
    size_t count = head.vertex_count;
    stp_assimp_put(w, mesh->mVertices, 3 * sizeof(float) * count);
    if ((head.flags & STP_ASSIMP_NORMALS) != 0) {
        stp_assimp_put(w, mesh->mNormals, 3 * sizeof(float) * count);
    }
    for (int set = 0; set < 2; ++set) {
        if ((head.flags & (set == 0 ? STP_ASSIMP_TEXCOORDS_0 : STP_ASSIMP_TEXCOORDS_1)) != 0) {
            put_texcoords(w, mesh, set);
        }
    }
    if ((head.flags & STP_ASSIMP_COLORS) != 0) {
        stp_assimp_put(w, mesh->mColors[0], 4 * sizeof(float) * count);
    }
    for (unsigned i = 0; triangles && i < mesh->mNumFaces; ++i) {
        if (mesh->mFaces[i].mNumIndices == 3) {
            stp_assimp_put(w, mesh->mFaces[i].mIndices, 3 * sizeof(uint32_t));
        }
    }
}

static const struct aiMetadataEntry* find_metadata(const struct aiScene* scene, const char* key)
{
    const struct aiMetadata* data = scene->mMetaData;
    for (unsigned i = 0; data != NULL && i < data->mNumProperties; ++i) {
        if (strcmp(data->mKeys[i].data, key) == 0) {
            return &data->mValues[i];
        }
    }
    return NULL;
}

static double metadata_number(const struct aiScene* scene, const char* key, double missing)
{
    const struct aiMetadataEntry* entry = find_metadata(scene, key);
    if (entry == NULL) {
        return missing;
    }
    switch (entry->mType) {
    case AI_INT32:
        return (double)*(const int32_t*)entry->mData;
    case AI_FLOAT:
        return (double)*(const float*)entry->mData;
    case AI_DOUBLE:
        return *(const double*)entry->mData;
    default:
        return missing;
    }
}

static int has_extension(const char* path, const char* words)
{
    const char* dot = strrchr(path, '.');
    char lower[16] = {0};
    for (size_t i = 0; dot != NULL && i + 1 < sizeof(lower) && dot[1 + i] != '\0'; ++i) {
        char c = dot[1 + i];
        lower[i] = c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
    }
    const char* found = dot != NULL && lower[0] != '\0' ? strstr(words, lower) : NULL;
    assert(words[0] == ' ' && words[strlen(words) - 1] == ' ' && "every word has spaces around");
    size_t length = strlen(lower);
    return found != NULL && found[-1] == ' ' && found[length] == ' ';
}

// Metres of the unit in the first tag of an AMF file; millimetres if it has none. assimp ignores it.
static double amf_unit(const unsigned char* bytes, size_t size)
{
    static const struct {
        const char* name;
        double metres;
    } units[] = {{"inch", 0.0254}, {"feet", 0.3048}, {"meter", 1.0}, {"micron", 1e-6}};
    char head[1024] = {0};
    size_t length = size < sizeof(head) ? size : sizeof(head) - 1;
    if (length > 0) {
        memcpy(head, bytes, length);
    }
    char* tag = strstr(head, "<amf");
    char* end = tag != NULL ? strchr(tag, '>') : NULL;
    if (end != NULL) {
        *end = '\0';
    }
    const char* unit = end != NULL ? strstr(tag, "unit=") : NULL;
    for (size_t i = 0; unit != NULL && i < sizeof(units) / sizeof(units[0]); ++i) {
        size_t name = strlen(units[i].name);
        if (strncmp(unit + 6, units[i].name, name) == 0 && unit[6 + name] == unit[5]) {
            return units[i].metres;
        }
    }
    return 0.001;
}

// Remaining axis and unit conversion. Most of assimp's readers already turn z up to y up.
static void put_axes(stp_assimp_writer* w, const stp_assimp_files* files)
{
    const char* path = files->path;
    uint32_t up = 0; // unknown
    double unit = 0.0;
    if (has_extension(path, " fbx ")) {
        up = metadata_number(w->scene, "UpAxis", 1.0) == 2.0 ? 'z' : 'y';
        unit = metadata_number(w->scene, "UnitScaleFactor", 1.0) * 0.01; // in centimetres
    } else if (has_extension(path, " dae zae ifc ifczip ")) {
        up = 'y';
        unit = 1.0;
    } else if (has_extension(path, " x3d x3db wrl vrml gltf ")) {
        up = 'y';
        unit = 1.0;
    } else if (has_extension(path, " amf ")) {
        up = 'z';
        unit = amf_unit(files->bytes, files->size);
    } else if (has_extension(path, " dxf ")) {
        up = STP_ASSIMP_TURNED_Z;
    } else if (has_extension(path, " blend ")) {
        up = 'z';
    }
    stp_assimp_put_u32(w, up);
    stp_assimp_put(w, &unit, sizeof(unit));
}

// Dummy meshes that assimp adds to show a skeleton without a mesh.
static int is_skeleton_dummy(const struct aiScene* scene, const struct aiMesh* mesh)
{
    struct aiString name = {0};
    (void)aiGetMaterialString(scene->mMaterials[mesh->mMaterialIndex], AI_MATKEY_NAME, &name);
    return strcmp(name.data, "SkeletonMaterial") == 0;
}

static void put_losses(stp_assimp_writer* w)
{
    const struct aiScene* scene = w->scene;
    stp_assimp_losses losses = {
        .animations = scene->mNumAnimations, .lights = scene->mNumLights, .heights = w->heights};
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        const struct aiMesh* mesh = scene->mMeshes[i];
        losses.skins += mesh->mNumBones > 0 && !is_skeleton_dummy(scene, mesh);
        losses.morphs += mesh->mNumAnimMeshes;
        losses.lines += mesh->mPrimitiveTypes == aiPrimitiveType_LINE;
    }
    stp_assimp_put(w, &losses, sizeof(losses));
}

static void put_scene(stp_assimp_writer* w, const stp_assimp_files* files)
{
    const struct aiScene* scene = w->scene;
    stp_assimp_put_u32(w, STP_ASSIMP_SCENE);
    put_axes(w, files);
    w->bumps = has_extension(files->path, " dae zae ");
    stp_assimp_put_u32(w, scene->mNumTextures);
    for (unsigned i = 0; i < scene->mNumTextures; ++i) {
        stp_assimp_put_texture(w, scene->mTextures[i]);
    }
    stp_assimp_put_u32(w, scene->mNumMaterials);
    for (unsigned i = 0; i < scene->mNumMaterials; ++i) {
        stp_assimp_put_material(w, scene->mMaterials[i]);
    }
    stp_assimp_put_u32(w, scene->mNumMeshes);
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        put_mesh(w, scene->mMeshes[i]);
    }
    stp_assimp_put_nodes(w);
    stp_assimp_put_u32(w, scene->mNumCameras);
    for (unsigned i = 0; i < scene->mNumCameras; ++i) {
        stp_assimp_put_view(w, scene->mCameras[i]);
    }
    put_losses(w);
    stp_assimp_put_u32(w, STP_ASSIMP_END);
}

static void put_refusals(stp_assimp_writer* w, const stp_assimp_files* files)
{
    assert(files->refused <= 2 && (files->refused == 0) == (files->reason == NULL));
    stp_assimp_put_u32(w, files->refused);
    if (files->refused > 0) {
        stp_assimp_put_text(w, files->first, strlen(files->first));
        stp_assimp_put_text(w, files->reason, strlen(files->reason));
    }
}

static void put_result(stp_assimp_writer* w, const stp_assimp_files* files)
{
    stp_assimp_put_u32(w, STP_ASSIMP_MAGIC);
    put_refusals(w, files);
    if (w->scene == NULL || w->scene->mRootNode == NULL) {
        const char* reason = aiGetErrorString();
        stp_assimp_put_u32(w, STP_ASSIMP_FAILED);
        stp_assimp_put_text(w, reason, strlen(reason));
    } else {
        put_scene(w, files);
    }
    flush(w);
}

int stp_assimp_run_child(const char* path, const unsigned char* bytes, size_t size, bool alone,
                         int descriptor)
{
    stp_assimp_writer* w = calloc(1, sizeof(stp_assimp_writer));
    struct aiPropertyStore* properties = aiCreatePropertyStore();
    if (w == NULL || properties == NULL) {
        return 1;
    }
    stp_assimp_files files;
    stp_assimp_files_begin(&files, path, bytes, size, alone);
    w->descriptor = descriptor;
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, 0);
    aiSetImportPropertyInteger(properties, AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, 1);
    unsigned flags = aiProcess_Triangulate | aiProcess_SortByPType |
                     aiProcess_JoinIdenticalVertices | aiProcess_FlipUVs;
    w->scene = aiImportFileExWithProperties(path, flags, &files.io, properties);
    put_result(w, &files);
    return w->failed; // the process' exit frees all memory
}
