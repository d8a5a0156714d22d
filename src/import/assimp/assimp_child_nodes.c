// SPDX-License-Identifier: MIT
// Nodes and cameras of assimp's scene, as the child process writes them.
#include "import/assimp/assimp_writer.h"

#include <assert.h>
#include <assimp/cimport.h>
#include <stdlib.h>
#include <string.h>

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
    assert(*count <= limit);
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

static uint32_t node_flags(const stp_assimp_writer* w, const node_walk* walk,
                           const struct aiNode* node)
{
    const char* name = node->mName.data;
    uint32_t moves = walk->moving != NULL && bsearch(&name, walk->moving, walk->moving_count,
                                                     sizeof(char*), compare_names) != NULL;
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
        moves |= w->scene->mMeshes[node->mMeshes[i]]->mNumBones > 0;
    }
    return moves != 0 ? STP_OBJECT_MOVING : 0;
}

static void put_nodes(stp_assimp_writer* w, node_walk* walk, const struct aiNode* node,
                      uint32_t parent)
{
    if (!is_plain_root(node)) {
        double transform[12];
        for (int i = 0; i < 12; ++i) {
            transform[i] = (double)matrix_rows(&node->mTransformation)[i];
        }
        stp_assimp_put_string(w, &node->mName);
        stp_assimp_put_u32(w, parent);
        stp_assimp_put_u32(w, node_flags(w, walk, node));
        stp_assimp_put(w, transform, sizeof(transform));
        stp_assimp_put_u32(w, node->mNumMeshes);
        stp_assimp_put(w, node->mMeshes, node->mNumMeshes * sizeof(uint32_t));
        parent = walk->written++;
    }
    for (unsigned i = 0; i < node->mNumChildren; ++i) {
        if (node->mChildren[i] != NULL) { // some readers leave gaps
            put_nodes(w, walk, node->mChildren[i], parent);
        }
    }
}

void stp_assimp_put_nodes(stp_assimp_writer* w)
{
    node_walk walk = {0};
    walk.moving = list_moving(w->scene, &walk.moving_count);
    uint32_t count = count_nodes(w->scene->mRootNode);
    stp_assimp_put_u32(w, count);
    put_nodes(w, &walk, w->scene->mRootNode, STP_NONE);
    assert(walk.written == count);
}

static const struct aiNode* find_node(const struct aiNode* node, const char* name)
{
    const struct aiNode* found = strcmp(node->mName.data, name) == 0 ? node : NULL;
    for (unsigned i = 0; found == NULL && i < node->mNumChildren; ++i) {
        found = node->mChildren[i] != NULL ? find_node(node->mChildren[i], name) : NULL;
    }
    return found;
}

void stp_assimp_put_view(stp_assimp_writer* w, const struct aiCamera* camera)
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
    stp_assimp_put_string(w, &camera->mName);
    stp_assimp_put(w, out, sizeof(out));
}
