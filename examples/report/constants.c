#include "report/constants.h"

#include <stdio.h>
#include <string.h>

/* SPIR-V 1.3, sections 2.3 and 3.32. */
enum { HEADER_WORDS = 5, MAGIC = 0x07230203, OP_NAME = 5, OP_SPEC_CONSTANT = 50, OP_DECORATE = 71, DECORATION_SPEC_ID = 1 };

/* Calls `visit` for each instruction; stops where it returns false. */
typedef bool (*visitor)(void *user, uint32_t opcode, uint32_t *operands, uint32_t count);

static bool each_instruction(uint32_t *words, uint32_t count, visitor visit, void *user)
{
    if (count < HEADER_WORDS || words[0] != MAGIC)
        return false;
    for (uint32_t at = HEADER_WORDS; at < count;) {
        uint32_t length = words[at] >> 16;
        if (!length || at + length > count || !visit(user, words[at] & 0xffffu, words + at + 1, length - 1))
            return false;
        at += length;
    }
    return true;
}

typedef struct search { uint32_t id; bool tunable; char name[CONSTANTS_NAME]; } search;

static bool look_up(void *user, uint32_t opcode, uint32_t *operands, uint32_t count)
{
    search *s = user;
    if (opcode == OP_NAME && count >= 2 && operands[0] == s->id)
        snprintf(s->name, sizeof s->name, "%s", (const char *)(operands + 1));
    if (opcode == OP_DECORATE && count == 3 && operands[0] == s->id && operands[1] == DECORATION_SPEC_ID)
        s->tunable = operands[2] >= CONSTANTS_FIRST_ID;
    return true;
}

typedef struct collection { shader_constants *out; uint32_t *words, count; } collection;

static bool add_place(shader_constants *c, const char *name, uint32_t *place)
{
    int i = 0;
    while (i < c->count && strcmp(c->list[i].name, name) != 0)
        i++;
    if (i == CONSTANTS_MAX || (i < c->count && c->list[i].place_count == CONSTANTS_PLACES))
        return false;
    shader_constant *found = &c->list[i];
    if (i == c->count) {
        memset(found, 0, sizeof *found);
        snprintf(found->name, sizeof found->name, "%s", name);
        c->count++;
    }
    found->places[found->place_count++] = place;
    return true;
}

static bool collect(void *user, uint32_t opcode, uint32_t *operands, uint32_t count)
{
    collection *c = user;
    if (opcode != OP_SPEC_CONSTANT || count != 3)
        return true;
    search s = { operands[1], false, "" };
    each_instruction(c->words, c->count, look_up, &s);
    return !s.tunable || !s.name[0] || add_place(c->out, s.name, &operands[2]);
}

bool constants_find(shader_constants *c, uint32_t *words, uint32_t size_bytes)
{
    collection all = { c, words, size_bytes / 4 };
    return each_instruction(words, size_bytes / 4, collect, &all);
}

float constants_get(const shader_constant *c)
{
    float value;
    memcpy(&value, c->places[0], sizeof value);
    return value;
}

void constants_set(const shader_constant *c, float value)
{
    for (int i = 0; i < c->place_count; i++)
        memcpy(c->places[i], &value, sizeof value);
}
