// Numbers and words as a page shows them, and the tiles at its head.

export const clock = (seconds) => {
  const tenths = Math.floor(Math.max(0, seconds) * 10 + 1e-6);
  const two = (number) => String(number).padStart(2, "0");
  return `${two(Math.floor(tenths / 36000))}:${two(Math.floor(tenths / 600) % 60)}:${two(Math.floor(tenths / 10) % 60)}.${tenths % 10}`;
};
export const plain = (value, unit = "") => (value === null || value === undefined ? "–" : `${String(value).replace("-", "−")}${unit && ` ${unit}`}`);

// Fill tiles: entries are a name, a value, and classes.
export function tiles(list, entries) {
  if (list.children.length !== entries.length) {
    list.replaceChildren(...entries.map(() => {
      const tile = document.createElement("div");
      tile.append(document.createElement("dt"), document.createElement("dd"));
      return tile;
    }));
  }
  entries.forEach(([name, value, kind = ""], k) => {
    const tile = list.children[k];
    tile.className = kind;
    tile.children[0].textContent = name;
    tile.children[1].textContent = value;
  });
}
