// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // MAP_ANONYMOUS, madvise
#include "base/core/large_blocks.h"

#include <assert.h>
#include <stdint.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define HUGE_PAGE ((size_t)2 << 20)
#define HUGE_SIZE ((size_t)4 << 20) // from this size on, huge pages save more than they cost

void stp_large_blocks_open(stp_large_blocks* blocks)
{
    *blocks = (stp_large_blocks){0};
    pthread_mutex_init(&blocks->mutex, NULL);
}

static size_t round_up(size_t size, size_t multiple)
{
    return (size + multiple - 1) / multiple * multiple;
}

static size_t whole_pages(size_t size)
{
    return round_up(size, (size_t)sysconf(_SC_PAGESIZE));
}

static void unmap(stp_large_block block)
{
    if (block.size != 0) {
        (void)munmap(block.memory, block.size);
    }
}

static stp_large_block take_kept(stp_large_blocks* blocks, size_t index)
{
    assert(index < blocks->kept_count && blocks->kept[index].size <= blocks->kept_bytes);
    stp_large_block block = blocks->kept[index];
    blocks->kept_count -= 1;
    blocks->kept_bytes -= block.size;
    memmove(&blocks->kept[index], &blocks->kept[index + 1],
            (blocks->kept_count - index) * sizeof(block));
    return block;
}

// Frees the oldest kept blocks until the limits hold; the last one only in part. The mutex is held.
static void trim(stp_large_blocks* blocks, size_t max_blocks, size_t max_bytes)
{
    while (blocks->kept_count > max_blocks || blocks->kept_bytes > max_bytes) {
        bool many = blocks->kept_count > max_blocks;
        size_t much = many ? SIZE_MAX : whole_pages(blocks->kept_bytes - max_bytes);
        stp_large_block* first = &blocks->kept[0];
        if (first->size <= much) {
            unmap(take_kept(blocks, 0));
            continue;
        }
        first->size -= much;
        blocks->kept_bytes -= much;
        unmap((stp_large_block){(unsigned char*)first->memory + first->size, much});
    }
}

void stp_large_blocks_close(stp_large_blocks* blocks)
{
    trim(blocks, 0, 0);
    assert(blocks->kept_count == 0 && blocks->kept_bytes == 0 && "sizes of kept blocks add up");
    pthread_mutex_destroy(&blocks->mutex);
}

// Keeps a block as the newest. Merges it with adjacent kept blocks.
static void keep(stp_large_blocks* blocks, stp_large_block block)
{
    for (size_t i = 0; i < blocks->kept_count;) {
        unsigned char* memory = blocks->kept[i].memory;
        unsigned char* end = memory + blocks->kept[i].size;
        if (end != block.memory && memory != (unsigned char*)block.memory + block.size) {
            i += 1;
            continue;
        }
        stp_large_block beside = take_kept(blocks, i);
        block.memory = end == block.memory ? beside.memory : block.memory;
        block.size += beside.size;
    }
    assert(blocks->kept_count < STP_LARGE_KEPT_LIMIT && "trimmed before");
    assert(block.size > 0 && block.size == whole_pages(block.size));
    blocks->kept[blocks->kept_count++] = block;
    blocks->kept_bytes += block.size;
}

// Takes the smallest kept block that is large enough. The remainder stays kept.
static stp_large_block reuse(stp_large_blocks* blocks, size_t size)
{
    size_t best = blocks->kept_count;
    for (size_t i = 0; i < blocks->kept_count; ++i) {
        size_t has = blocks->kept[i].size;
        if (has >= size && (best == blocks->kept_count || has < blocks->kept[best].size)) {
            best = i;
        }
    }
    if (best == blocks->kept_count) {
        return (stp_large_block){0};
    }
    stp_large_block block = blocks->kept[best];
    if (block.size == size) {
        return take_kept(blocks, best);
    }
    blocks->kept[best] = (stp_large_block){(unsigned char*)block.memory + size, block.size - size};
    blocks->kept_bytes -= size;
    return (stp_large_block){block.memory, size};
}

static void* map(size_t size)
{
    size_t extra = size < HUGE_SIZE ? 0 : HUGE_PAGE;
    unsigned char* mapped =
        mmap(NULL, size + extra, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED || extra == 0) {
        return mapped == MAP_FAILED ? NULL : mapped;
    }
    size_t before = round_up((uintptr_t)mapped, HUGE_PAGE) - (uintptr_t)mapped;
    unmap((stp_large_block){mapped, before});
    unmap((stp_large_block){mapped + before + size, extra - before});
#if defined(MADV_HUGEPAGE)
    // only a hint; not for the last partial page, which would make the block larger than requested
    (void)madvise(mapped + before, size / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
#endif
    assert(before + size <= size + extra && (uintptr_t)(mapped + before) % HUGE_PAGE == 0);
    return mapped + before;
}

void* stp_large_alloc(stp_large_blocks* blocks, size_t size, size_t max_kept)
{
    if (size > SIZE_MAX / 2) {
        return NULL;
    }
    size = whole_pages(size);
    pthread_mutex_lock(&blocks->mutex);
    stp_large_block block = reuse(blocks, size);
    trim(blocks, STP_LARGE_KEPT_LIMIT, max_kept);
    pthread_mutex_unlock(&blocks->mutex);
    return block.memory != NULL ? block.memory : map(size);
}

void stp_large_free(stp_large_blocks* blocks, void* memory, size_t size, size_t max_kept)
{
    assert((uintptr_t)memory % whole_pages(1) == 0 && "from stp_large_alloc");
    stp_large_block block = {memory, whole_pages(size)};
    pthread_mutex_lock(&blocks->mutex);
    if (block.size <= max_kept) {
        trim(blocks, STP_LARGE_KEPT_LIMIT - 1, max_kept - block.size);
        keep(blocks, block);
        block.size = 0;
    } else {
        trim(blocks, STP_LARGE_KEPT_LIMIT, max_kept);
    }
    pthread_mutex_unlock(&blocks->mutex);
    unmap(block);
}

void stp_large_discard(void* memory, size_t size)
{
#if defined(MADV_DONTNEED)
    size_t page = whole_pages(1);
    uintptr_t begin = round_up((uintptr_t)memory, page);
    uintptr_t end = ((uintptr_t)memory + size) / page * page;
    if (begin < end) {
        (void)madvise((unsigned char*)memory + (begin - (uintptr_t)memory), end - begin,
                      MADV_DONTNEED);
    }
#else
    (void)memory, (void)size;
#endif
}
