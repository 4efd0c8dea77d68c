// Lists of what a person can go to.

export const words = (name) => name.replaceAll("_", " ");

// Fill a list: of each item its cells (tag, text, class, small print), what it does, and a button.
export function list(place, items, whenEmpty) {
  place.replaceChildren(...items.map(({ of, cells, go, action }) => {
    const item = document.createElement("li");
    item.tabIndex = 0;
    if (of !== undefined) item.dataset.of = of;
    item.append(...cells.map(([tag, text, kind = "", small = ""]) => {
      const cell = document.createElement(tag);
      cell.textContent = text;
      if (kind) cell.className = kind;
      if (small) {
        const print = document.createElement("small");
        print.textContent = ` ${small}`;
        cell.append(print);
      }
      return cell;
    }));
    item.onclick = go;
    item.onkeydown = (event) => { if (event.key === "Enter" && event.target === item) go(); };
    if (action) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = action[0];
      button.onclick = (event) => { event.stopPropagation(); action[1](); };
      item.append(button);
    }
    return item;
  }));
  if (!items.length && whenEmpty) {
    const item = document.createElement("li");
    item.className = "empty";
    item.textContent = whenEmpty;
    place.append(item);
  }
}
