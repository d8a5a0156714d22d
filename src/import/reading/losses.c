// SPDX-License-Identifier: MIT
#include "import/reading/losses.h"

#include <assert.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct loss_text {
    const char *one, *many;
    const char* instead; ///< NULL: it is left out
} loss_text;

static const loss_text texts[STP_LOSS_COUNT] = {
#define X(name, one, many, instead) {one, many, instead},
    STP_LOSSES(X)
#undef X
};

void stp_losses_add(stp_losses* losses, stp_loss loss, uint64_t count)
{
    assert((unsigned)loss < STP_LOSS_COUNT);
    losses->counts[loss] += count;
}

void stp_losses_add_extension(stp_losses* losses, const char* name)
{
    size_t used = strlen(losses->extensions), length = strlen(name);
    size_t gap = used > 0 ? 2 : 0;
    if (length == 0 || used + gap + length + 1 > sizeof(losses->extensions)) {
        losses->unnamed_extensions += 1;
        return;
    }
    memcpy(losses->extensions + used, ", ", gap);
    for (size_t i = 0; i <= length; ++i) {
        unsigned char c = (unsigned char)name[i];
        losses->extensions[used + gap + i] = (char)(c == 0 || (c > 0x20 && c < 0x7F) ? c : '?');
    }
    assert(strlen(losses->extensions) == used + gap + length);
}

typedef struct sentence {
    char bytes[1536]; ///< longer than all texts and extensions together
    size_t used;
} sentence;

static void append(sentence* s, const char* format, ...) __attribute__((format(printf, 2, 3)));

// Starts the next item of the list.
static void append(sentence* s, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    int gap =
        snprintf(s->bytes + s->used, sizeof(s->bytes) - s->used, "%s", s->used > 0 ? "; " : "");
    assert(s->used + (size_t)gap < sizeof(s->bytes) && "it is longer than all texts together");
    s->used += (size_t)gap;
    int length = vsnprintf(s->bytes + s->used, sizeof(s->bytes) - s->used, format, list);
    size_t room = sizeof(s->bytes) - s->used - 1;
    s->used += (size_t)length < room ? (size_t)length : room;
    va_end(list);
}

void stp_losses_report(stp_context* context, const char* path, const stp_losses* losses)
{
    sentence s = {.used = 0};
    for (int i = 0; i < STP_LOSS_COUNT; ++i) {
        uint64_t count = losses->counts[i];
        const loss_text* text = &texts[i];
        if (count > 0) {
            append(&s, "%llu %s%s%s%s", (unsigned long long)count,
                   count == 1 ? text->one : text->many, text->instead != NULL ? " (" : "",
                   text->instead != NULL ? text->instead : "", text->instead != NULL ? ")" : "");
        }
    }
    if (losses->extensions[0] != '\0' && losses->unnamed_extensions > 0) {
        append(&s, "extensions %s and %u more", losses->extensions, losses->unnamed_extensions);
    } else if (losses->extensions[0] != '\0') {
        append(&s, "extension%s %s", strchr(losses->extensions, ',') != NULL ? "s" : "",
               losses->extensions);
    } else if (losses->unnamed_extensions > 0) {
        append(&s, "%u extension%s", losses->unnamed_extensions,
               losses->unnamed_extensions > 1 ? "s" : "");
    }
    if (s.used > 0) {
        stp_warn(context, "%s: not kept: %s", path, s.bytes);
    }
}
