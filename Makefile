# make               everything: SPIR-V modules, examples, tests (into build/)
# make demo          renders a moving scene, denoises it, prints an error/time table; installs what is missing
# make test          builds and runs all tests; installs what is missing
# make test-long     what the tests try to break, for some hours: 100,000 frames, 20,000 random cases, every fault planted; the cases again
#                    under ASan and UBSan
# make dist          build/nrd-sdk/: what an engine needs; no shader compiler among it
# make gpu           build/gpu/: programs and tests with their libraries, for machines that have none; then, over there,
#                    NRD_BUILD=build/gpu tests/run.sh test_gpu test_vk. tracer=1 adds nrd-render (60 MB)
# make report        build/report/report.html: error against run time of all denoisers, within the hour; QUICK=1: 3 minutes into
#                    build/report-quick; REPORT='...' adds options of nrd-report
# make publish       measures this machine's first device and writes what README and nrd.h say of it (examples/report/publish.sh: of others)
# make tune          searches settings and shader constants of DENOISER (reblur_diffuse); TUNE='...' adds options of nrd-tune
# Others: spv shared check examples format clean.
# Options: config=release|debug|sanitize, werror=1, V=1 (shows commands); own settings: Makefile.config (untracked).
config ?= release
werror ?= 0
-include Makefile.config

flags_release  := -O2
flags_debug    := -O0 -g
flags_sanitize := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
ifeq ($(flags_$(config)),)
$(error config=$(config): must be release, debug or sanitize)
endif

B := $(if $(filter release,$(config)),build,build-$(config))
Q := $(if $(V),,@)
ALL_CFLAGS = -std=c99 -Wall -Wextra -pedantic $(if $(filter 1,$(werror)),-Werror) $(flags_$(config)) $(CPPFLAGS) $(CFLAGS)
INCLUDES   = -I. -I$B -Iexamples -Itests
LIBS       = -lOpenEXRCore -lpng -lcmocka -lm -ldl -lpthread
GLSL       = glslangValidator --quiet -V --target-env vulkan1.1 -Inrd_shaders --depfile $@.d
SHARED     = sed -n '/>>shared begin/,/>>shared end/p' nrd.h | \
             sed -e '1s/.*/\/* Cut out of nrd.h by `make shared`; edit it there. *\//' -e '$$d'
# Included files become targets without rules, so that deleting one does not break the next build.
end_deps = sed 's/^[^:]*: *//' $@.d | tr ' ' '\n' | sed 's/$$/:/' >> $@.d
# Uses all processors unless -j is already given.
submake  = $(MAKE) --no-print-directory $(if $(filter -j%,$(MAKEFLAGS)),,-j$(shell nproc))

modules  := $(shell sed -n 's/^\([a-z][a-z0-9_]*\) .*/\1/p' nrd_shaders/modules.txt)
spv      := $(modules:%=$B/spv/%.spv)
kernels  := $B/trace_spv.h $B/spatial_spv.h $B/copy_buffers_spv.h $B/copy_images_spv.h $B/tests/shader_math_spirv.h $B/tests/shader_math_debug_spirv.h
embedded := $B/nrd_spirv.h $(kernels) $B/raygen_spv.h $B/report_page.h
objects   = $(patsubst %.c,$B/obj/%.o,$(wildcard $1))
programs := $B/minimal $(patsubst examples/nrd_%.c,$B/nrd-%,$(wildcard examples/nrd_*.c))
tests    := $(patsubst tests/%.c,$B/tests/%,$(wildcard tests/test_*.c))
archives := $B/libstress.a $B/libreport.a $B/libtracer.a $B/libexamples.a
gpu      := $(patsubst $B/%,$B/gpu/%,$(filter-out $(if $(tracer),,%/nrd-render %/test_tracer %/test_shadows),$(programs) $(tests)))

.PHONY: all spv shared test test-long check examples demo report publish tune dist gpu format clean
.DELETE_ON_ERROR:
.SECONDARY:

all: spv examples $(tests)
examples: $(programs)
spv: $B/nrd_spirv.h
	@cat $(spv) | wc -c | sed 's/.*/SPIR-V: $(words $(spv)) modules, & bytes/'

# ---- shaders
shared: nrd_shaders/common/nrd_shared.glsl
nrd_shaders/common/nrd_shared.glsl: nrd.h
	@mkdir -p $B && $(SHARED) > $B/shared.tmp
	@cmp -s $B/shared.tmp $@ || { cp $B/shared.tmp $@ && echo "updated $@"; }

$(spv): $B/spv/%.spv: nrd_shaders/modules.txt nrd_shaders/common/nrd_shared.glsl Makefile
	@echo "glsl $*"; mkdir -p $(@D)
	$Qset -- $$(grep '^$* ' $<) && file=nrd_shaders/$$2 && shift 2 && $(GLSL) $(if $(filter release,$(config)),-Os) "$$@" $$file -o $@
	@$(end_deps)

# All modules as C arrays: folder of the .spv files, how the arrays are qualified.
spirv_header = @$B/spirv-header $1 "$2" $(modules) > $@
$B/spirv-header: examples/dist/spirv_header.c nrd.h
	@echo "cc   $<"; mkdir -p $(@D)
	$Q$(CC) $(ALL_CFLAGS) -I. $< -lm -o $@

$B/nrd_spirv.h: $(spv) $B/spirv-header
	$(call spirv_header,$B/spv,const)

# Tuning build: the named float constants of the families become specialization constants, ids from 100 on, in copies of the
# shaders; those with six digits or more are mathematics and stay.
shaders := $(wildcard nrd_shaders/*.* nrd_shaders/*/*.*)
$B/tune/nrd_spirv.h: $(shaders) $B/spirv-header Makefile
	@echo "tune glsl"; rm -rf $B/tune/src && mkdir -p $B/tune/src && cp -R nrd_shaders/. $B/tune/src && \
	    cat nrd_shaders/*/* > $B/tune/names
	$Qfor f in $$(cd nrd_shaders && ls */* | grep -v ^common/); do awk -v file=$$f 'BEGIN { id = 100 } \
	    FNR == NR { if (/^const float [A-Z0-9_]+ = -?[0-9.e-]+;/ && !($$3 in ids)) ids[$$3] = id++; next } \
	    /^const float [A-Z0-9_]+ = -?[0-9.e-]+;/ { digits = $$5; gsub(/[^0-9]/, "", digits); \
	        if (length(digits) < 6) $$0 = "layout(constant_id = " ids[$$3] ") " $$0 } { print }' \
	    $B/tune/names nrd_shaders/$$f > $B/tune/src/$$f || exit 1; done
	$Qmkdir -p $B/tune/spv && for m in $(modules); do set -- $$(grep "^$$m " nrd_shaders/modules.txt | sed 's/ -g0//') && file=$B/tune/src/$$2 && shift 2 && \
	    glslangValidator --quiet -V --target-env vulkan1.1 -I$B/tune/src "$$@" $$file -o $B/tune/spv/$$m.spv || exit 1; done
	$(call spirv_header,$B/tune/spv)

$B/trace_spv.h: examples/tracer/trace.comp
$B/spatial_spv.h: examples/report/spatial.comp
$B/copy_buffers_spv.h: examples/report/copy_buffers.comp
$B/copy_images_spv.h: examples/report/copy_images.comp
$B/tests/shader_math_spirv.h $B/tests/shader_math_debug_spirv.h: tests/shader_math.comp
$B/tests/shader_math_spirv.h: GLSL += -Os
$B/tests/shader_math_debug_spirv.h: GLSL += -Od -g
$(kernels): Makefile
	@echo "glsl $(firstword $(filter %.comp,$^))"; mkdir -p $(@D)
	$Q$(GLSL) --vn $(basename $(@F)) $(firstword $(filter %.comp,$^)) -o $@
	@$(end_deps)

# The shaders of examples/raygen, one array each. Ray tracing stages need SPIR-V 1.4.
raygen := loop.comp compose.comp primary.rgen surface.rchit sky.rmiss
$(raygen:%=$B/raygen/%.h): $B/raygen/%.h: examples/raygen/% Makefile
	@echo "glsl $<"; mkdir -p $(@D)
	$Q$(GLSL) $(if $(filter %.comp,$<),,--target-env spirv1.4) --vn $(subst .,_,$(<F)) $< -o $@
	@$(end_deps)
$B/raygen_spv.h: $(raygen:%=$B/raygen/%.h)
	@sed 's/^const/static const/; /#pragma once/d' $^ > $@

$B/report_page.h: examples/report/page.html
	@{ echo 'static const unsigned char report_page[] = {'; od -An -v -tx1 $< | sed 's/ \(..\)/0x\1,/g'; echo '0};'; } > $@

# ---- C
$B/obj/%.o: %.c Makefile | $(embedded)
	@echo "cc   $<"; mkdir -p $(@D)
	$Q$(CC) $(ALL_CFLAGS) -MMD -MP $(INCLUDES) -c $< -o $@

$B/libexamples.a: $(call objects,examples/common/*.c examples/raygen/*.c)
$B/obj/examples/nrd_tune.o: INCLUDES := -I$B/tune $(INCLUDES)
$B/obj/examples/nrd_tune.o: $B/tune/nrd_spirv.h

$B/libreport.a: $(call objects,examples/report/*.c)
$B/libstress.a: $(call objects,examples/stress/*.c)
$B/libtracer.a: $(call objects,examples/scenes/*.c examples/tracer/*.c)
$(archives):
	$Qrm -f $@ && ar rcs $@ $^

define link
	@echo "link $@"; mkdir -p $(@D)
	$Q$(CC) $(ALL_CFLAGS) $(LDFLAGS) -Wl,--as-needed $< $(archives) $(LIBS) -o $@
endef
%/nrd-render %/test_tracer %/test_shadows: LIBS += -lembree3 -lassimp
$(gpu): LDFLAGS += -static-libgcc -Wl,--disable-new-dtags,-rpath,'$$ORIGIN:$$ORIGIN/..'
define program_rules
$1/minimal: $B/obj/examples/minimal.o $(archives)
	$$(link)
$1/nrd-%: $B/obj/examples/nrd_%.o $(archives)
	$$(link)
$1/tests/test_%: $B/obj/tests/test_%.o $(archives)
	$$(link)
endef
$(foreach folder,$B $B/gpu,$(eval $(call program_rules,$(folder))))

gpu: $(gpu)
	@ldd $(gpu) | awk '$$2 == "=>" && $$1 !~ /^(libc|libm|libdl|libpthread|librt)\.so/ && !index($$3, "/$B/gpu/") { print $$3 }' | sort -u | \
	    xargs -r cp -uLt $B/gpu && du -sh $B/gpu

# ---- what one runs
check:
	@$(SHARED) | cmp - nrd_shaders/common/nrd_shared.glsl || { echo "run: make shared" >&2; exit 1; }
	@! grep -rnE 'TODO|FIXME|#if 0' nrd.h nrd_vk.h nrd_shaders examples tests || { echo "unfinished code" >&2; exit 1; }

test:
	@examples/setup.sh
	@$(submake) check
	@$(submake) all dist
	@NRD_BUILD=$B tests/run.sh

test-long: $B/nrd-stress
	@$B/nrd-stress --all --quiet
	@$B/nrd-stress --self-test
	@$(submake) config=sanitize build-sanitize/nrd-stress
	@LSAN_OPTIONS=suppressions=tests/lsan.supp build-sanitize/nrd-stress --all --quiet --only fuzz

demo:
	@examples/setup.sh
	@$(submake) examples
	@NRD_BUILD=$B examples/demo.sh

report: $B/nrd-report
	@$B/nrd-report $B/report$(if $(QUICK),-quick --quick) $(REPORT)

publish: $B/nrd-report
	@NRD_BUILD=$B examples/report/publish.sh run $B/report-published $(REPORT)
	@examples/report/publish.sh take $B/report-published

DENOISER ?= reblur_diffuse
tune: $B/nrd-tune
	@$B/nrd-tune $(DENOISER) $B/report-quick $(TUNE)

dist: $B/nrd_spirv.h
	@rm -rf $B/nrd-sdk && mkdir -p $B/nrd-sdk
	@cp -R nrd.h nrd_vk.h nrd_shaders $B/nrd_spirv.h LICENSE $(wildcard README.md) $B/nrd-sdk

format:
	clang-format -i nrd.h nrd_vk.h $(wildcard examples/*.c examples/*/*.[ch] tests/*.[ch])

clean:
	rm -rf build build-debug build-sanitize

-include $(shell find $B -name '*.d' 2>/dev/null)
