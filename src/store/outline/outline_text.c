// SPDX-License-Identifier: MIT
// Names: paths and text search.
#include "base/core/printable.h"
#include "store/outline/outline_internal.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

static bool has_text(const char* text)
{
    return text != NULL && text[0] != '\0';
}

stp_result stp_outline_path(stp_outline* outline, const stp_outline_item* item, char* text,
                            size_t size)
{
    size_t used = 0;
    assert(item->depth <= STP_OUTLINE_DEPTH);
    if (size > 0) {
        text[0] = '\0';
    }
    for (uint32_t i = 0; i < item->depth && used < size; ++i) {
        stp_store_object object;
        stp_result result = stp_store_read_object(outline->store, item->objects[i], &object);
        if (result != STP_OK) {
            return result;
        }
        const char* slash = i > 0 ? "/" : object.parent != STP_STORE_NONE ? ".../" : "";
        int length = has_text(object.name)
                         ? snprintf(text + used, size - used, "%s%s", slash, object.name)
                         : snprintf(text + used, size - used, "%s#%u", slash, item->objects[i]);
        used += length > 0 ? (size_t)length : 0;
    }
    if (used >= size && size > 0) {
        text[stp_utf8_whole(text, size - 1)] = '\0';
    }
    return STP_OK;
}

/// The next UTF-8 character of at most two bytes, in lower case for Latin, Greek and Cyrillic. All
/// else counts as bytes.
static uint32_t next_folded(const char** text)
{
    const unsigned char* p = (const unsigned char*)*text;
    uint32_t c = p[0];
    if (c < 0x80 || (c & 0xE0) != 0xC0 || (p[1] & 0xC0) != 0x80) {
        *text += 1;
        return c >= 'A' && c <= 'Z' ? c + 32 : c;
    }
    c = (c & 0x1F) << 6 | (p[1] & 0x3F);
    *text += 2;
    bool latin = c >= 0xC0 && c <= 0xDE && c != 0xD7;
    bool greek = c >= 0x391 && c <= 0x3A9 && c != 0x3A2;
    bool cyrillic = c >= 0x410 && c <= 0x42F;
    if (latin || greek || cyrillic) {
        return c + 32;
    }
    if (c >= 0x400 && c <= 0x40F) {
        return c + 80;
    }
    return c >= 0x100 && c <= 0x137 ? c | 1 : c; // adjacent upper and lower case pairs
}

static bool contains(const char* name, const char* text)
{
    for (; name != NULL && *name != '\0'; (void)next_folded(&name)) {
        const char *a = name, *b = text;
        while (*b != '\0' && *a != '\0') {
            const char *after_a = a, *after_b = b;
            if (next_folded(&after_a) != next_folded(&after_b)) {
                break;
            }
            a = after_a;
            b = after_b;
        }
        if (*b == '\0') {
            return true;
        }
    }
    return false;
}

stp_outline_search stp_outline_search_begin(const char* text)
{
    stp_outline_search search = {0};
    snprintf(search.text, sizeof(search.text), "%s", text);
    return search;
}

stp_result stp_outline_search_on(stp_outline* outline, stp_outline_search* search, uint32_t records,
                                 uint32_t room, uint32_t* objects, uint32_t* count)
{
    uint32_t all = outline->directory->object_count;
    assert(search->next <= all);
    *count = 0;
    for (uint32_t i = 0; i < records && search->next < all && *count < room; ++i) {
        stp_store_object object;
        stp_result result = stp_store_read_object(outline->store, search->next, &object);
        if (result != STP_OK) {
            return result;
        }
        if (search->text[0] != '\0' &&
            (contains(object.name, search->text) || contains(object.id, search->text))) {
            objects[(*count)++] = search->next;
            search->matches += 1;
        }
        search->next += 1;
    }
    return STP_OK;
}

/// Whether the first `length` bytes of a path end with the object's label; *rest: the bytes before
/// it.
static bool ends_with(const char* text, size_t length, const char* name, size_t* rest)
{
    size_t own = strlen(name);
    if (own > length || memcmp(text + length - own, name, own) != 0) {
        return false;
    }
    *rest = length - own;
    return true;
}

stp_result stp_outline_is_named(stp_outline* outline, uint32_t object, const char* text,
                                bool* named)
{
    size_t length = strlen(text);
    bool first = true;
    *named = false;
    while (true) {
        stp_store_object record;
        char number[16];
        stp_result result = stp_store_read_object(outline->store, object, &record);
        if (result != STP_OK) {
            return result;
        }
        snprintf(number, sizeof(number), "#%u", object);
        bool is_number = first && strcmp(text, number) == 0;
        bool is_id = first && has_text(record.id) && strcmp(text, record.id) == 0;
        size_t rest = length;
        bool ends = ends_with(text, length, has_text(record.name) ? record.name : number, &rest);
        if (is_number || is_id || (ends && rest == 0)) {
            *named = true;
            return STP_OK;
        }
        if (!ends || rest < 2 || text[rest - 1] != '/' || record.parent == STP_STORE_NONE) {
            return STP_OK;
        }
        length = rest - 1;
        object = record.parent;
        first = false;
    }
}

typedef struct path_search {
    stp_outline* outline;
    const stp_vec3d* near;
    stp_outline_item* best;
    double distance; ///< squared distance of the best match
    bool found;
    uint64_t visits; ///< visits left
} path_search;

/// Keeps an item that has the path if it is nearer than earlier ones.
static void keep_nearest(path_search* s, const stp_outline_item* item)
{
    double distance = 0.0;
    if (s->near != NULL && item->node != STP_STORE_NONE) {
        stp_boxd box =
            stp_affine_box(&item->transform, s->outline->directory->nodes[item->node].bounds);
        stp_vec3d half = stp_scaled(stp_subd(box.max, box.min), 0.5);
        stp_vec3d away = stp_subd(stp_addd(box.min, half), *s->near);
        distance = stp_dotd(away, away);
    }
    if (!s->found || distance < s->distance) {
        s->found = true;
        s->distance = distance;
        *s->best = *item;
    }
}

/// Matches the rest of a path below an item.
static stp_result find_rest(path_search* s, const stp_outline_item* item, const char* rest)
{
    enum { ROOM = 8 };
    stp_outline_item items[ROOM];
    uint32_t count = ROOM;
    stp_result result = STP_OK;
    for (uint64_t first = 0; result == STP_OK && count == ROOM; first += ROOM) {
        result = stp_outline_children(s->outline, item, first, ROOM, items, &count);
        for (uint32_t i = 0; result == STP_OK && i < count && s->visits > 0; ++i) {
            stp_store_object object;
            char number[16];
            assert(items[i].depth == item->depth + 1);
            uint32_t index = items[i].objects[items[i].depth - 1];
            s->visits -= 1;
            result = stp_store_read_object(s->outline->store, index, &object);
            if (result != STP_OK) {
                return result;
            }
            snprintf(number, sizeof(number), "#%u", index);
            const char* name = has_text(object.name) ? object.name : number;
            size_t length = strlen(name);
            if (strncmp(rest, name, length) != 0) {
                continue;
            }
            if (rest[length] == '\0') {
                keep_nearest(s, &items[i]);
            } else if (rest[length] == '/') {
                result = find_rest(s, &items[i], rest + length + 1);
            }
        }
    }
    return result;
}

stp_result stp_outline_by_path(stp_outline* outline, const char* path, const stp_vec3d* near,
                               stp_outline_item* item, bool* found)
{
    stp_outline_item root = stp_outline_root(outline);
    path_search s = {.outline = outline, .near = near, .best = item, .visits = UINT64_C(1) << 27};
    stp_result result = find_rest(&s, &root, path);
    *found = s.found;
    return result;
}
