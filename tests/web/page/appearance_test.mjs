// SPDX-License-Identifier: Apache-2.0
// How models look in the page: textures, materials, colours and edges, by the colours of pixels.
import assert from "node:assert/strict";
import { mkdirSync, writeFileSync } from "node:fs";
import { describe, test } from "node:test";
import { crc32, deflateSync } from "node:zlib";
import { pageFile, settled } from "./browser.mjs";
import {
  assertSameFiles,
  choose,
  download,
  drop,
  file,
  makeBox,
  message,
  run,
  until,
  withPage,
} from "./person.mjs";

const kRed = [255, 0, 0];
const kGreen = [0, 255, 0];
const kBlue = [0, 0, 255];
const kYellow = [255, 255, 0];

/** A .png of 8 by 8 pixels: four squares of one colour, in the order of the text. */
function png(topLeft, topRight, bottomLeft, bottomRight) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const [length, check] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(data.length);
    check.writeUInt32BE(crc32(body));
    return Buffer.concat([length, body, check]);
  };
  const header = Buffer.from([0, 0, 0, 8, 0, 0, 0, 8, 8, 2, 0, 0, 0]);
  const row = (left, right) => [
    0,
    ...[0, 1, 2, 3].flatMap(() => left),
    ...[0, 1, 2, 3].flatMap(() => right),
  ];
  const rows = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((y) =>
    y < 4 ? row(topLeft, topRight) : row(bottomLeft, bottomRight),
  );
  return Buffer.concat([
    Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]),
    chunk("IHDR", header),
    chunk("IDAT", deflateSync(Buffer.from(rows))),
    chunk("IEND", Buffer.alloc(0)),
  ]);
}
const kPicture = png(kRed, kGreen, kBlue, kYellow);

/** A square from -1 to 1, which shows the whole picture. */
const kSquare = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
const kSquareObj = `mtllib square.mtl\n${kSquare}usemtl wood\nf 1/1 2/2 3/3 4/4\n`;
const kSquareMtl = "newmtl\twood\nTr 1\nKd 1 1 1\nmap_Kd -bm 1 C:\\pictures\\Wood.PNG\n";

/** The same square in glTF. `image` gives the picture, `buffer` the place of the numbers. */
function gltf(image, buffer, views = []) {
  const numbers = Buffer.concat([
    Buffer.from(Float32Array.from([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]).buffer),
    Buffer.from(Float32Array.from([0, 1, 1, 1, 1, 0, 0, 0]).buffer), // v points downwards
    Buffer.from(Uint16Array.from([0, 1, 2, 0, 2, 3]).buffer),
  ]);
  const json = {
    asset: { version: "2.0" },
    buffers: [{ byteLength: numbers.length, ...buffer }],
    bufferViews: [
      { buffer: 0, byteLength: 48 },
      { buffer: 0, byteOffset: 48, byteLength: 32 },
      { buffer: 0, byteOffset: 80, byteLength: 12 },
      ...views,
    ],
    accessors: [
      {
        bufferView: 0,
        componentType: 5126,
        count: 4,
        type: "VEC3",
        min: [-1, -1, 0],
        max: [1, 1, 0],
      },
      { bufferView: 1, componentType: 5126, count: 4, type: "VEC2" },
      { bufferView: 2, componentType: 5123, count: 6, type: "SCALAR" },
    ],
    images: [image],
    textures: [{ source: 0 }],
    materials: [
      { pbrMetallicRoughness: { baseColorFactor: [1, 0, 1, 1] } },
      { pbrMetallicRoughness: { baseColorTexture: { index: 0 }, metallicFactor: 0 } },
    ],
    meshes: [
      { primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 1 }] },
    ],
    nodes: [{ mesh: 0 }],
    scenes: [{ nodes: [0] }],
    scene: 0,
  };
  return { json, numbers };
}

function glb(json, binary) {
  const padded = (bytes, fill) =>
    Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);
  const chunk = (type, bytes) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length);
    head.write(type, 4, "latin1");
    return Buffer.concat([head, bytes]);
  };
  const chunks = [
    chunk("JSON", padded(Buffer.from(JSON.stringify(json)), " ")),
    chunk("BIN\0", padded(binary, 0)),
  ];
  const head = Buffer.alloc(12);
  head.write("glTF");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([head, ...chunks]);
}

async function opened(page, files) {
  await drop(page, files);
  await until(page, () => globalThis.espalier.editor.document.models.length > 0);
}

/** The colours of the picture at points, seen from the end of an axis, with nothing but the model. */
async function coloursAt(page, points, side = "+z") {
  await page.evaluate(
    (to) => document.querySelector(`#axes [title="Look from ${to}"]`).click(),
    side,
  );
  await settled(page);
  return page.evaluate((all) => {
    const { view } = globalThis.espalier.editor;
    view.shown = { ...view.shown, lattice: false };
    view.draw();
    const copy = new OffscreenCanvas(view.canvas.width, view.canvas.height).getContext("2d");
    copy.drawImage(view.canvas, 0, 0);
    return all.map((point) => {
      const place = view.camera.position.clone().fromArray(point).project(view.camera);
      const x = Math.round(((place.x + 1) / 2) * view.canvas.width);
      const y = Math.round(((1 - place.y) / 2) * view.canvas.height);
      return [...copy.getImageData(x, y, 1, 1).data];
    });
  }, points);
}

/** The name of a colour. */
function nameOf([red, green, blue, opacity]) {
  if (opacity < 128) return "nothing";
  const strong = [red, green, blue].map((x) => x > 0.6 * Math.max(red, green, blue));
  const names = {
    "true,false,false": "red",
    "false,true,false": "green",
    "false,false,true": "blue",
    "true,true,false": "yellow",
    "true,true,true": "grey",
  };
  return names[strong] ?? `${[red, green, blue]}`;
}
const namesOf = async (page, points, side) => (await coloursAt(page, points, side)).map(nameOf);

const kQuarters = [
  [-0.5, 0.5, 0],
  [0.5, 0.5, 0],
  [-0.5, -0.5, 0],
  [0.5, -0.5, 0],
];
const kColours = ["red", "green", "blue", "yellow"];

/** Makes the model twice as wide by its lattice. */
async function widen(page) {
  await makeBox(page, 1);
  await page.keyboard.press("a");
  await page.evaluate(() =>
    globalThis.espalier.editor.transform({ kind: "scale", factors: [2, 1, 1] }),
  );
  await settled(page);
}

describe("the look of a model", () => {
  test("an .obj with its .mtl and its picture shows the picture, also in a pose", () =>
    withPage(async (page) => {
      await opened(page, {
        "WOOD.png": kPicture,
        "square.obj": kSquareObj,
        "square.mtl": kSquareMtl,
      });
      assert.deepEqual(await namesOf(page, kQuarters), kColours);
      await widen(page);
      const wide = kQuarters.map(([x, y, z]) => [3 * x, y, z]);
      assert.deepEqual(await namesOf(page, wide), kColours);
      await page.evaluate(() => document.querySelector('[data-shown="materials"]').click());
      assert.deepEqual(await namesOf(page, wide), ["grey", "grey", "grey", "grey"]);
    }));

  test("a point with two texture coordinates is drawn with both, also in a pose", () =>
    withPage(async (page) => {
      // Two halves, each with the whole picture. The points in the middle are at its right and its left edge.
      const points = [-1, 0, 1].flatMap((x) => [`v ${x} -1 0\n`, `v ${x} 1 0\n`]).join("");
      const corners = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 3/2 4/3 2/4\nf 3/1 5/2 6/3 4/4\n";
      await opened(page, { "halves.obj": points + corners, "wood.png": kPicture });
      const places = (width) =>
        [-0.75, -0.25, 0.25, 0.75].flatMap((x) => [
          [width * x, 0.5, 0],
          [width * x, -0.5, 0],
        ]);
      const colours = ["red", "blue", "green", "yellow", "red", "blue", "green", "yellow"];
      assert.deepEqual(await namesOf(page, places(1)), colours);
      await widen(page);
      assert.deepEqual(await namesOf(page, places(2)), colours);
    }));

  test("two pictures of one name are told apart by their folders", async () => {
    mkdirSync(file("a"), { recursive: true });
    mkdirSync(file("b"), { recursive: true });
    writeFileSync(file("a/tex.png"), png(kRed, kRed, kRed, kRed));
    writeFileSync(file("b/tex.png"), png(kBlue, kBlue, kBlue, kBlue));
    writeFileSync(
      file("two.mtl"),
      "newmtl left\nmap_Kd a/tex.png\nnewmtl right\nmap_Kd b\\tex.png\n",
    );
    const left = "v -1 -1 0\nv 0 -1 0\nv 0 1 0\nv -1 1 0\nvt 0.5 0.5\nusemtl left\nf 1/1 2/1 3/1 4/1\n";
    const right = "v 1 -1 0\nv 1 1 0\nusemtl right\nf 2/1 5/1 6/1 3/1\n";
    writeFileSync(file("two-halves.obj"), `mtllib two.mtl\n${left}${right}`);
    run("page", "two-halves.obj", "--page", pageFile, "-o", file("halves.html"));
    await withPage(
      async (page) => {
        await until(page, () => globalThis.espalier.editor.models.length > 0);
        assert.deepEqual(await namesOf(page, [[-0.5, 0, 0], [0.5, 0, 0]]), ["red", "blue"]); // prettier-ignore
      },
      { file: file("halves.html") },
    );
  });

  test("a page of espalier page has the .mtl and the picture inside", async () => {
    const files = { "wood.png": kPicture, "square.obj": kSquareObj, "square.mtl": kSquareMtl };
    for (const [name, content] of Object.entries(files)) writeFileSync(file(name), content);
    run("page", "square.obj", "--page", pageFile, "-o", file("sent.html"));
    await withPage(
      async (page) => {
        await until(page, () => globalThis.espalier.editor.models.length > 0);
        assert.deepEqual(await namesOf(page, kQuarters), kColours);
      },
      { file: file("sent.html") },
    );
  });

  test("files that are missing are named, and come later; undo takes them away", () =>
    withPage(async (page) => {
      await opened(page, { "square.obj": kSquareObj });
      assert.match(await message(page), /1 material of square\.obj is not here: drop its \.mtl/);
      assert.equal(await page.isDisabled('[data-shown="materials"]'), true);
      await drop(page, { "square.mtl": kSquareMtl });
      await until(page, () => /Wood/.test(document.querySelector("#message span").textContent));
      assert.match(
        await message(page),
        /^1 texture of square\.mtl is not here: drop Wood\.PNG together with the model$/,
      );
      assert.deepEqual(await namesOf(page, kQuarters), ["grey", "grey", "grey", "grey"]);
      await drop(page, { "wood.png": kPicture });
      await until(page, () => globalThis.espalier.editor.document.models[0].companions.length === 2);
      assert.deepEqual(await namesOf(page, kQuarters), kColours);
      await page.keyboard.press("Control+z");
      await settled(page);
      assert.deepEqual(await namesOf(page, kQuarters), ["grey", "grey", "grey", "grey"]);
    }));

  test("a .glb shows the picture inside it", () =>
    withPage(async (page) => {
      const { json, numbers } = gltf({ bufferView: 3, mimeType: "image/png" }, {}, [
        { buffer: 0, byteOffset: 92, byteLength: kPicture.length },
      ]);
      json.buffers[0].byteLength = 92 + kPicture.length;
      writeFileSync(file("square.glb"), glb(json, Buffer.concat([numbers, kPicture])));
      await choose(page, "open", file("square.glb"));
      await until(page, () => globalThis.espalier.editor.document.models.length > 0);
      assert.deepEqual(await namesOf(page, kQuarters), kColours);
    }));

  test("a .gltf with its .bin and its picture is opened, posed and taken home", () =>
    withPage(async (page) => {
      const { json, numbers } = gltf({ uri: "textures/my%20wood.png" }, { uri: "data/square.bin" });
      const text = JSON.stringify(json);
      await drop(page, { "square.gltf": text });
      await page.waitForSelector("#message:not([hidden])");
      assert.equal(
        await message(page),
        "square.gltf has its points in square.bin: drop both together",
      );
      assert.deepEqual(await page.evaluate(() => globalThis.espalier.editor.document.models), []);
      await opened(page, { "square.gltf": text, "square.bin": numbers, "my wood.png": kPicture });
      assert.deepEqual(await namesOf(page, kQuarters), kColours);
      await widen(page);
      assert.deepEqual(
        await namesOf(
          page,
          kQuarters.map(([x, y, z]) => [3 * x, y, z]),
        ),
        kColours,
      );
      const [rest, pose, taken] = [
        await download(page, "save rest"),
        await download(page, "save pose", "pose.vtu"),
        await download(page, "save model"),
      ];
      assert.match(taken, /square-deformed\.glb$/);
      const whole = { ...json, buffers: [{ ...json.buffers[0], uri: "square.bin" }] };
      writeFileSync(file("square.bin"), numbers);
      writeFileSync(file("square.gltf"), JSON.stringify(whole));
      run(
        "deform",
        "square.gltf",
        "--rest",
        rest,
        "--to",
        pose,
        "-o",
        file("expected.glb"),
        "--level",
        "3",
      );
      assertSameFiles(taken, file("expected.glb"));
      // Another .bin has other points.
      const wider = Buffer.from(numbers);
      wider.writeFloatLE(-4, 0);
      await drop(page, { "square.bin": wider });
      await until(page, () => globalThis.espalier.editor.models[0].points[0] === -4);
      assert.ok(await page.evaluate(() => globalThis.espalier.editor.binding !== null));
    }));

  test("the colours of the points of a .ply are shown, with and without faces", () =>
    withPage(async (page) => {
      const points = [
        [-1, -1, 0, ...kRed],
        [1, -1, 0, ...kRed],
        [1, 1, 0, ...kBlue],
        [-1, 1, 0, ...kBlue],
      ];
      const ply = (faces) =>
        [
          "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z",
          "property uchar red\nproperty uchar green\nproperty uchar blue",
          `element face ${faces.length}\nproperty list uchar int vertex_indices\nend_header`,
          ...points.map((point) => point.join(" ")),
          ...faces,
        ].join("\n") + "\n";
      await opened(page, { "colours.ply": ply(["4 0 1 2 3"]) });
      assert.deepEqual(
        await namesOf(page, [
          [0, -0.9, 0],
          [0, 0.9, 0],
        ]),
        ["red", "blue"],
      );
      await drop(page, { "cloud.ply": ply([]) });
      await until(page, () => globalThis.espalier.editor.document.models[0].name === "cloud.ply");
      assert.deepEqual(
        await namesOf(page, [
          [1, -1, 0],
          [1, 1, 0],
        ]),
        ["red", "blue"],
      );
      // Points of a cloud can be pulled.
      await makeBox(page, 2);
      await page.keyboard.press("Numpad1");
      await page.keyboard.press("p");
      await settled(page);
      const picked = await page.evaluate(() => {
        const { view } = globalThis.espalier.editor;
        const place = view.camera.position.clone().fromArray(view.points, 6).project(view.camera);
        const { clientWidth: width, clientHeight: height } = view.canvas;
        const [x, y] = [((place.x + 1) / 2) * width, ((1 - place.y) / 2) * height];
        return [view.pointAt(x, y), view.pointAt(x + 60, y)];
      });
      assert.deepEqual(picked, [2, null]);
    }));

  test("the edges of a box are hard, and a round surface is smooth", () =>
    withPage(async (page) => {
      const box = [0, 1, 2, 3, 4, 5, 6, 7]
        .map((i) => `v ${i & 1} ${(i >> 1) & 1} ${i >> 2}\n`)
        .join("");
      const faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
      await opened(page, { "box.obj": box + faces });
      // A face of one normal has one colour, also near the corners.
      const [middle, corner] = await coloursAt(page, [
        [0.5, 0.5, 1],
        [0.96, 0.04, 1],
      ]);
      assert.ok(Math.abs(middle[0] - corner[0]) <= 2, `${middle} and ${corner}`);
      const copies = await page.evaluate(
        () => globalThis.espalier.editor.models[0].drawn.copies.length,
      );
      assert.equal(copies, 16);
      // A roof of 30 degrees is smooth.
      const height = Math.tan(Math.PI / 12);
      const roof = `v 0 0 0\nv 0 0 1\nv 1 ${height} 0\nv 1 ${height} 1\nv 2 0 0\nv 2 0 1\n`;
      await drop(page, { "roof.obj": `${roof}f 1 2 4 3\nf 3 4 6 5\n` });
      await until(page, () => globalThis.espalier.editor.document.models[0].name === "roof.obj");
      const none = await page.evaluate(() => globalThis.espalier.editor.models[0].drawn.copies.length);
      assert.equal(none, 0);
    }));

  test("the points of a model stay the points that are pulled and shown", () =>
    withPage(async (page) => {
      const two =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 1 -1 -2\nv 1 1 -2\nf 1 2 3 4\nf 2 5 6 3\n";
      await opened(page, { "corner.obj": two });
      const { points, at } = await page.evaluate(() => {
        const { view, models: [model] } = globalThis.espalier.editor;
        view.look(view.camera.position.clone().set(1, 0, 0));
        const place = view.camera.position.clone().set(1, 0.9, -0.1).project(view.camera);
        const { clientWidth: width, clientHeight: height } = view.canvas;
        const [x, y] = [((place.x + 1) / 2) * width, ((1 - place.y) / 2) * height];
        return { points: [...view.points], at: view.pointAt(x, y), copies: model.drawn.copies };
      });
      assert.equal(points.length, 18);
      assert.equal(at, 2);
    }));

  test("splats are ellipses of their colours, from the back to the front, and turn with a pose", () =>
    withPage(async (page) => {
      const names =
        "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
      const [on, off, opaque] = [1.77, -1.77, 6];
      const [long, round, thin] = [0.6, 0.5, 0.05].map(Math.log);
      const rows = [
        [0, 0, 1, on, off, off, opaque, long, thin, thin, 1, 0, 0, 0],
        [0, 0, 0, off, off, on, opaque, round, round, round, 1, 0, 0, 0],
      ];
      const ply = [
        "ply\nformat ascii 1.0\nelement vertex 2",
        ...names.split(" ").map((name) => `property float ${name}`),
        "end_header",
        ...rows.map((row) => row.join(" ")),
      ];
      await opened(page, { "two.ply": ply.join("\n") + "\n" });
      const places = [
        [0, 0, 0.5],
        [0.45, 0, 0.5],
        [0, 0.45, 0.5],
        [-1.8, 1.8, 0.5],
      ];
      assert.deepEqual(await namesOf(page, places), ["red", "red", "blue", "nothing"]);
      assert.deepEqual(await namesOf(page, places.slice(0, 1), "−z"), ["blue"]);
      await makeBox(page, 1);
      await page.keyboard.press("a");
      await page.evaluate(() => {
        const { editor } = globalThis.espalier;
        return editor.transform({ kind: "rotate", axis: "z", degrees: 90, center: [0, 0, 0] });
      });
      await settled(page);
      assert.deepEqual(await namesOf(page, places), ["red", "blue", "red", "nothing"]);
      await page.selectOption('[data-setting="normals"]', "keep");
      await settled(page);
      assert.deepEqual(await namesOf(page, places), ["red", "red", "blue", "nothing"]);
    }));
});
