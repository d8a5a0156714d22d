// SPDX-License-Identifier: MIT
//
// The child process: writes assimp's scene as a stream. It runs after fork() with a single thread;
// errors end the child, not the caller.
#include "import/assimp_files.h"
#include "import/assimp_stream.h"
#include "import/surface.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BUFFER_SIZE ((size_t)1 << 16)

typedef struct writer {
    int descriptor;
    int failed;
    size_t used;
    const struct aiScene* scene;
    unsigned char buffer[BUFFER_SIZE];
} writer;

static void flush(writer* w)
{
    for (size_t at = 0; at < w->used && !w->failed;) {
        ssize_t done = write(w->descriptor, w->buffer + at, w->used - at);
        w->failed = done < 0 && errno != EINTR;
        at += done > 0 ? (size_t)done : 0;
    }
    w->used = 0;
}

static void put(writer* w, const void* bytes, size_t size)
{
    const unsigned char* at = bytes;
    while (size > 0 && !w->failed) {
        size_t room = BUFFER_SIZE - w->used;
        size_t part = size < room ? size : room;
        memcpy(w->buffer + w->used, at, part);
        w->used += part;
        at += part;
        size -= part;
        if (w->used == BUFFER_SIZE) {
            flush(w);
        }
    }
}

static void put_u32(writer* w, uint32_t value)
{
    put(w, &value, sizeof(value));
}

static void put_text(writer* w, const char* text, size_t length)
{
    length = length < STP_ASSIMP_TEXT_LIMIT ? length : STP_ASSIMP_TEXT_LIMIT;
    put_u32(w, (uint32_t)length);
    put(w, text, length);
}

static void put_string(writer* w, const struct aiString* string)
{
    put_text(w, string->data, string->length);
}

static void put_texture(writer* w, const struct aiTexture* texture)
{
    put_string(w, &texture->mFilename);
    put_u32(w, texture->mWidth);
    put_u32(w, texture->mHeight);
    if (texture->mHeight == 0) {
        put(w, texture->pcData, texture->mWidth);
        return;
    }
    for (size_t i = 0; i < (size_t)texture->mWidth * texture->mHeight; ++i) {
        const struct aiTexel* texel = &texture->pcData[i];
        unsigned char rgba[4] = {texel->r, texel->g, texel->b, texel->a};
        put(w, rgba, sizeof(rgba));
    }
}

static uint32_t wrap_of(enum aiTextureMapMode mode)
{
    return mode == aiTextureMapMode_Mirror  ? STP_WRAP_MIRROR
           : mode == aiTextureMapMode_Clamp ? STP_WRAP_CLAMP
                                            : STP_WRAP_REPEAT;
}

static const char* file_name(const char* path)
{
    const char* name = path;
    for (; *path != '\0'; ++path) {
        name = *path == '/' || *path == '\\' ? path + 1 : name;
    }
    return name;
}

// "*3" is the third embedded texture; some formats name embedded ones by their file name.
static uint32_t find_embedded(const struct aiScene* scene, const char* path)
{
    if (path[0] == '*') {
        return (uint32_t)strtoul(path + 1, NULL, 10);
    }
    for (uint32_t i = 0; i < scene->mNumTextures; ++i) {
        const char* name = file_name(scene->mTextures[i]->mFilename.data);
        if (name[0] != '\0' && strcmp(name, file_name(path)) == 0) {
            return i;
        }
    }
    return STP_NONE;
}

static int get_texture(const struct aiMaterial* material, enum aiTextureType type,
                       struct aiString* path, stp_assimp_use* use)
{
    unsigned texcoord = 0;
    enum aiTextureMapMode modes[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap,
                                      aiTextureMapMode_Wrap};
    *use = (stp_assimp_use){.scale = {1, 1}};
    if (aiGetMaterialTexture(material, type, 0, path, NULL, &texcoord, NULL, NULL, modes, NULL) !=
            aiReturn_SUCCESS ||
        path->length == 0) {
        return 0;
    }
    struct aiUVTransform transform;
    if (aiGetMaterialUVTransform(material, AI_MATKEY_UVTRANSFORM(type, 0), &transform) ==
        aiReturn_SUCCESS) {
        use->scale[0] = transform.mScaling.x;
        use->scale[1] = transform.mScaling.y;
        use->offset[0] = transform.mTranslation.x;
        use->offset[1] = transform.mTranslation.y;
    }
    use->texcoord = texcoord;
    use->wrap_u = wrap_of(modes[0]);
    use->wrap_v = wrap_of(modes[1]);
    return 1;
}

static void put_use(writer* w, const struct aiString* path, const stp_assimp_use* use)
{
    uint32_t embedded = path != NULL ? find_embedded(w->scene, path->data) : STP_NONE;
    put_u32(w, path == NULL           ? STP_ASSIMP_NO_TEXTURE
               : embedded != STP_NONE ? STP_ASSIMP_EMBEDDED
                                      : STP_ASSIMP_PATH);
    put_u32(w, embedded);
    put_text(w, path != NULL ? path->data : "", path != NULL ? path->length : 0);
    put(w, use, sizeof(*use));
}

static int get_color(const struct aiMaterial* material, const char* key, float* rgb)
{
    struct aiColor4D color;
    int found = aiGetMaterialColor(material, key, 0, 0, &color) == aiReturn_SUCCESS;
    if (found) {
        memcpy(rgb, &color, 3 * sizeof(float));
    }
    return found;
}

static void decode(float* rgb)
{
    for (int i = 0; i < 3; ++i) {
        rgb[i] = stp_srgb_to_linear(rgb[i]);
    }
}

// Colours of formats without physical materials are sRGB; base colours are linear. A picture
// replaces a diffuse colour.
static void put_material(writer* w, const struct aiMaterial* material)
{
    stp_assimp_material out = {.base_color = {1, 1, 1, 1}, .roughness = 1};
    struct aiString name = {0}, base = {0}, emissive = {0}, opacity = {0};
    stp_assimp_use base_use, emissive_use, unused;
    (void)aiGetMaterialString(material, AI_MATKEY_NAME, &name);
    int has_base = get_texture(material, aiTextureType_BASE_COLOR, &base, &base_use) ||
                   get_texture(material, aiTextureType_DIFFUSE, &base, &base_use);
    int has_emissive = get_texture(material, aiTextureType_EMISSIVE, &emissive, &emissive_use);
    out.masked = get_texture(material, aiTextureType_OPACITY, &opacity, &unused) && has_base &&
                 strcmp(opacity.data, base.data) == 0;
    int physical = get_color(material, "$clr.base", out.base_color);
    if (!physical && !has_base && get_color(material, "$clr.diffuse", out.base_color)) {
        decode(out.base_color);
    }
    if (get_color(material, "$clr.emissive", out.emissive) && !physical) {
        decode(out.emissive);
    }
    float value;
    if (aiGetMaterialFloatArray(material, AI_MATKEY_OPACITY, &value, NULL) == aiReturn_SUCCESS &&
        value > 0.0f) { // 0 is almost always a misread transparency
        out.base_color[3] = value;
    }
    if (aiGetMaterialFloatArray(material, AI_MATKEY_SHININESS, &value, NULL) == aiReturn_SUCCESS &&
        value > 0.0f) {
        out.roughness = sqrtf(sqrtf(2.0f / (value + 2.0f))); // as in mtl.c
    }
    if (aiGetMaterialFloatArray(material, AI_MATKEY_METALLIC_FACTOR, &value, NULL) ==
        aiReturn_SUCCESS) {
        out.metallic = value;
    }
    if (aiGetMaterialFloatArray(material, AI_MATKEY_ROUGHNESS_FACTOR, &value, NULL) ==
        aiReturn_SUCCESS) {
        out.roughness = value;
    }
    put_string(w, &name);
    put(w, &out, sizeof(out));
    put_use(w, has_base ? &base : NULL, &base_use);
    put_use(w, has_emissive ? &emissive : NULL, &emissive_use);
}

static void put_texcoords(writer* w, const struct aiMesh* mesh, int set)
{
    for (unsigned i = 0; i < mesh->mNumVertices; ++i) {
        float uv[2] = {mesh->mTextureCoords[set][i].x, mesh->mTextureCoords[set][i].y};
        put(w, uv, sizeof(uv));
    }
}

static void put_mesh(writer* w, const struct aiMesh* mesh)
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
    put_string(w, &mesh->mName);
    put(w, &head, sizeof(head));
    size_t count = head.vertex_count;
    put(w, mesh->mVertices, 3 * sizeof(float) * count);
    if ((head.flags & STP_ASSIMP_NORMALS) != 0) {
        put(w, mesh->mNormals, 3 * sizeof(float) * count);
    }
    for (int set = 0; set < 2; ++set) {
        if ((head.flags & (set == 0 ? STP_ASSIMP_TEXCOORDS_0 : STP_ASSIMP_TEXCOORDS_1)) != 0) {
            put_texcoords(w, mesh, set);
        }
    }
    if ((head.flags & STP_ASSIMP_COLORS) != 0) {
        put(w, mesh->mColors[0], 4 * sizeof(float) * count);
    }
    for (unsigned i = 0; triangles && i < mesh->mNumFaces; ++i) {
        if (mesh->mFaces[i].mNumIndices == 3) {
            put(w, mesh->mFaces[i].mIndices, 3 * sizeof(uint32_t));
        }
    }
}

static const float* matrix_rows(const struct aiMatrix4x4* matrix)
{
    return &matrix->a1; // 16 floats in row-major order
}

static int is_identity(const struct aiMatrix4x4* matrix)
{
    for (int i = 0; i < 16; ++i) {
        if (matrix_rows(matrix)[i] != (i % 5 == 0 ? 1.0f : 0.0f)) {
            return 0;
        }
    }
    return 1;
}

// The file's own root often carries no information; then its children become children of our root.
static int is_plain_root(const struct aiNode* node)
{
    return node->mParent == NULL && node->mNumMeshes == 0 && is_identity(&node->mTransformation);
}

static uint32_t count_nodes(const struct aiNode* node)
{
    uint32_t count = is_plain_root(node) ? 0 : 1;
    for (unsigned i = 0; i < node->mNumChildren; ++i) {
        count += node->mChildren[i] != NULL ? count_nodes(node->mChildren[i]) : 0;
    }
    return count;
}

static int compare_names(const void* a, const void* b)
{
    return strcmp(*(const char* const*)a, *(const char* const*)b);
}

// Sorted names of the nodes that animations move.
static const char** list_moving(const struct aiScene* scene, size_t* count)
{
    size_t limit = 0;
    for (unsigned i = 0; i < scene->mNumAnimations; ++i) {
        limit += scene->mAnimations[i]->mNumChannels;
    }
    const char** names = calloc(limit + 1, sizeof(char*));
    *count = 0;
    for (unsigned i = 0; names != NULL && i < scene->mNumAnimations; ++i) {
        const struct aiAnimation* animation = scene->mAnimations[i];
        for (unsigned k = 0; k < animation->mNumChannels; ++k) {
            const struct aiNodeAnim* channel = animation->mChannels[k];
            if (channel->mNumPositionKeys > 1 || channel->mNumRotationKeys > 1 ||
                channel->mNumScalingKeys > 1) {
                names[(*count)++] = channel->mNodeName.data;
            }
        }
    }
    if (names != NULL) {
        qsort(names, *count, sizeof(char*), compare_names);
    }
    return names;
}

// State of the nodes while they are written.
typedef struct node_walk {
    const char** moving;
    size_t moving_count;
    uint32_t written;
} node_walk;

static uint32_t node_flags(const writer* w, const node_walk* walk, const struct aiNode* node)
{
    const char* name = node->mName.data;
    uint32_t moves = walk->moving != NULL && bsearch(&name, walk->moving, walk->moving_count,
                                                     sizeof(char*), compare_names) != NULL;
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        moves |= w->scene->mMeshes[node->mMeshes[i]]->mNumBones > 0;
    }
    return moves != 0 ? STP_OBJECT_MOVING : 0;
}

static void put_nodes(writer* w, node_walk* walk, const struct aiNode* node, uint32_t parent)
{
    if (!is_plain_root(node)) {
        double transform[12];
        for (int i = 0; i < 12; ++i) {
            transform[i] = (double)matrix_rows(&node->mTransformation)[i];
        }
        put_string(w, &node->mName);
        put_u32(w, parent);
        put_u32(w, node_flags(w, walk, node));
        put(w, transform, sizeof(transform));
        put_u32(w, node->mNumMeshes);
        put(w, node->mMeshes, node->mNumMeshes * sizeof(uint32_t));
        parent = walk->written++;
    }
    for (unsigned i = 0; i < node->mNumChildren; ++i) {
        if (node->mChildren[i] != NULL) { // some readers leave gaps
            put_nodes(w, walk, node->mChildren[i], parent);
        }
    }
}

static const struct aiNode* find_node(const struct aiNode* node, const char* name)
{
    const struct aiNode* found = strcmp(node->mName.data, name) == 0 ? node : NULL;
    for (unsigned i = 0; found == NULL && i < node->mNumChildren; ++i) {
        found = node->mChildren[i] != NULL ? find_node(node->mChildren[i], name) : NULL;
    }
    return found;
}

static void put_view(writer* w, const struct aiCamera* camera)
{
    struct aiMatrix4x4 world;
    aiIdentityMatrix4(&world);
    const struct aiNode* node = find_node(w->scene->mRootNode, camera->mName.data);
    for (; node != NULL; node = node->mParent) {
        struct aiMatrix4x4 whole = node->mTransformation;
        aiMultiplyMatrix4(&whole, &world);
        world = whole;
    }
    struct aiVector3D eye = camera->mPosition, target = camera->mPosition, top = camera->mPosition;
    aiVector3Add(&target, &camera->mLookAt);
    aiVector3Add(&top, &camera->mUp);
    struct aiVector3D* points[3] = {&eye, &target, &top};
    double out[10];
    for (int i = 0; i < 3; ++i) {
        aiTransformVecByMatrix4(points[i], &world);
        out[3 * i] = (double)points[i]->x;
        out[3 * i + 1] = (double)points[i]->y;
        out[3 * i + 2] = (double)points[i]->z;
    }
    for (int i = 6; i < 9; ++i) {
        out[i] -= out[i - 6]; // up is a direction
    }
    // half the horizontal angle; for narrow views it shrinks roughly with the aspect
    double aspect = camera->mAspect > 0.0f ? (double)camera->mAspect : 4.0 / 3.0;
    out[9] = 2.0 * (double)camera->mHorizontalFOV * 57.29577951308232 / aspect;
    put_string(w, &camera->mName);
    put(w, out, sizeof(out));
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
    size_t length = strlen(lower);
    return found != NULL && found[-1] == ' ' && found[length] == ' ';
}

// Remaining axis and unit conversion. Most of assimp's readers already turn z up to y up.
static void put_axes(writer* w, const char* path)
{
    uint32_t up = 0; // unknown
    double unit = 0.0;
    if (has_extension(path, " fbx ")) {
        up = metadata_number(w->scene, "UpAxis", 1.0) == 2.0 ? 'z' : 'y';
        unit = metadata_number(w->scene, "UnitScaleFactor", 1.0) * 0.01; // of a centimetre
    } else if (has_extension(path, " dae zae ifc ifczip ")) {
        up = 'y';
        unit = 1.0;
    } else if (has_extension(path, " x3d x3db wrl vrml gltf ")) {
        up = 'y';
        unit = 1.0;
    } else if (has_extension(path, " 3mf amf ")) {
        up = 'z';
        unit = 0.001;
    } else if (has_extension(path, " dxf ")) {
        up = 'z';
    }
    put_u32(w, up);
    put(w, &unit, sizeof(unit));
}

// Dummy meshes that assimp adds to show a skeleton without a mesh.
static int is_skeleton_dummy(const struct aiScene* scene, const struct aiMesh* mesh)
{
    struct aiString name = {0};
    (void)aiGetMaterialString(scene->mMaterials[mesh->mMaterialIndex], AI_MATKEY_NAME, &name);
    return strcmp(name.data, "SkeletonMaterial") == 0;
}

static void put_losses(writer* w)
{
    const struct aiScene* scene = w->scene;
    stp_assimp_losses losses = {.animations = scene->mNumAnimations, .lights = scene->mNumLights};
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        const struct aiMesh* mesh = scene->mMeshes[i];
        losses.skins += mesh->mNumBones > 0 && !is_skeleton_dummy(scene, mesh);
        losses.morphs += mesh->mNumAnimMeshes;
        losses.lines += mesh->mPrimitiveTypes == aiPrimitiveType_LINE;
    }
    put(w, &losses, sizeof(losses));
}

static void put_scene(writer* w, const char* path)
{
    const struct aiScene* scene = w->scene;
    put_u32(w, STP_ASSIMP_SCENE);
    put_axes(w, path);
    put_u32(w, scene->mNumTextures);
    for (unsigned i = 0; i < scene->mNumTextures; ++i) {
        put_texture(w, scene->mTextures[i]);
    }
    put_u32(w, scene->mNumMaterials);
    for (unsigned i = 0; i < scene->mNumMaterials; ++i) {
        put_material(w, scene->mMaterials[i]);
    }
    put_u32(w, scene->mNumMeshes);
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        put_mesh(w, scene->mMeshes[i]);
    }
    node_walk walk = {0};
    walk.moving = list_moving(scene, &walk.moving_count);
    put_u32(w, count_nodes(scene->mRootNode));
    put_nodes(w, &walk, scene->mRootNode, STP_NONE);
    put_u32(w, scene->mNumCameras);
    for (unsigned i = 0; i < scene->mNumCameras; ++i) {
        put_view(w, scene->mCameras[i]);
    }
    put_losses(w);
    put_u32(w, STP_ASSIMP_END);
}

static void put_refusals(writer* w, const stp_assimp_files* files)
{
    put_u32(w, files->refused);
    if (files->refused > 0) {
        put_text(w, files->first, strlen(files->first));
        put_text(w, files->reason, strlen(files->reason));
    }
}

static void put_result(writer* w, const char* path, const stp_assimp_files* files)
{
    put_u32(w, STP_ASSIMP_MAGIC);
    put_refusals(w, files);
    if (w->scene == NULL || w->scene->mRootNode == NULL) {
        const char* reason = aiGetErrorString();
        put_u32(w, STP_ASSIMP_FAILED);
        put_text(w, reason, strlen(reason));
    } else {
        put_scene(w, path);
    }
    flush(w);
}

int stp_assimp_run_child(const char* path, const unsigned char* bytes, size_t size, bool alone,
                         int descriptor)
{
    writer* w = calloc(1, sizeof(writer));
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
    put_result(w, path, &files);
    return w->failed; // the process' exit frees all memory
}
